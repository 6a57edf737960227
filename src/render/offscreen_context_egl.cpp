// EGL on Mesa's surfaceless platform: for systems whose Mesa has no OSMesa any more.
#include <EGL/egl.h>
#include <EGL/eglext.h>

#include <cstdio>
#include <string>

#include "odeval/error.hpp"
#include "render/offscreen_context.hpp"

namespace odeval::render {
namespace {

[[noreturn]] void fail(const std::string& what) {
  char code[16];
  std::snprintf(code, sizeof code, "0x%x", static_cast<unsigned>(eglGetError()));
  throw MachineError("EGL: no " + what + " (" + code + ")");
}

EGLDisplay surfaceless_display() {
  const auto get = reinterpret_cast<PFNEGLGETPLATFORMDISPLAYEXTPROC>(eglGetProcAddress("eglGetPlatformDisplayEXT"));
  return get == nullptr ? EGL_NO_DISPLAY : get(EGL_PLATFORM_SURFACELESS_MESA, EGL_DEFAULT_DISPLAY, nullptr);
}

}  // namespace

struct OffscreenContext::Library {
  EGLDisplay display = EGL_NO_DISPLAY;
  EGLSurface surface = EGL_NO_SURFACE;
  EGLContext context = EGL_NO_CONTEXT;

  ~Library() {
    if (display == EGL_NO_DISPLAY) return;
    eglMakeCurrent(display, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
    if (context != EGL_NO_CONTEXT) eglDestroyContext(display, context);
    if (surface != EGL_NO_SURFACE) eglDestroySurface(display, surface);
    eglTerminate(display);
    eglReleaseThread();
  }
};

OffscreenContext::OffscreenContext(int width, int height)
    : width_(width), height_(height), library_(std::make_unique<Library>()) {
  EGLDisplay& display = library_->display;
  display = surfaceless_display();
  if (display == EGL_NO_DISPLAY || eglInitialize(display, nullptr, nullptr) == EGL_FALSE) {
    fail("surfaceless display");
  }
  if (eglBindAPI(EGL_OPENGL_API) == EGL_FALSE) fail("desktop OpenGL");

  constexpr EGLint wanted[] = {EGL_SURFACE_TYPE,
                               EGL_PBUFFER_BIT,
                               EGL_RENDERABLE_TYPE,
                               EGL_OPENGL_BIT,
                               EGL_RED_SIZE,
                               8,
                               EGL_GREEN_SIZE,
                               8,
                               EGL_BLUE_SIZE,
                               8,
                               EGL_ALPHA_SIZE,
                               8,
                               EGL_DEPTH_SIZE,
                               24,
                               EGL_STENCIL_SIZE,
                               8,
                               EGL_NONE};
  EGLConfig config = nullptr;
  EGLint found = 0;
  if (eglChooseConfig(display, wanted, &config, 1, &found) == EGL_FALSE || found == 0) fail("fitting framebuffer");
  const EGLint size[] = {EGL_WIDTH, width, EGL_HEIGHT, height, EGL_NONE};
  library_->surface = eglCreatePbufferSurface(display, config, size);
  library_->context = eglCreateContext(display, config, EGL_NO_CONTEXT, nullptr);
  if (eglMakeCurrent(display, library_->surface, library_->surface, library_->context) == EGL_FALSE) {
    fail("OpenGL context of " + std::to_string(width) + "x" + std::to_string(height));
  }
}

OffscreenContext::~OffscreenContext() = default;

}  // namespace odeval::render
