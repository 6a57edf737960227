// open_painter once more, with the path of the EGL twin's module: an executable's own definition goes before a
// library's.
#include "render/painter.cpp"
