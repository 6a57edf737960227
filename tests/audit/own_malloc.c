/* A malloc of the program's own, as games and browsers have one: it takes the next bytes of one piece of memory, and
 * aborts where what is given back is not of it. It calls nothing that might call it. */
#include <errno.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>

enum { alignment = 16 };
static const size_t all = (size_t)1 << 32; /* never all of it taken: the machine gives what is written to */
static char* begin;
static size_t used; /* of it */

static size_t* size_of(void* place) { return (size_t*)place - 1; }

static void* take(size_t wanted, size_t aligned) {
  if (__atomic_load_n(&begin, __ATOMIC_ACQUIRE) == 0) { /* at first there is one thread */
    void* got = mmap(0, all, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
    if (got == MAP_FAILED) abort();
    __atomic_store_n(&begin, (char*)got, __ATOMIC_RELEASE);
  }
  if (wanted > all / 2) return 0;
  const size_t place = __atomic_fetch_add(&used, wanted + alignment + aligned, __ATOMIC_RELAXED);
  if (place > all / 2) return 0;
  const uintptr_t first = (uintptr_t)begin + place + alignment;
  char* mine = (char*)((first + aligned - 1) / aligned * aligned);
  *size_of(mine) = wanted;
  return mine;
}

static void require_mine(void* place) {
  if ((char*)place < begin || (char*)place >= begin + all) abort();
}

void* malloc(size_t wanted) {
  void* place = take(wanted, alignment);
  if (place != 0) memset(place, 0xa5, wanted);
  return place;
}

void free(void* place) {
  if (place == 0) return;
  require_mine(place);
  memset(place, 0x5a, *size_of(place));
}

void* calloc(size_t count, size_t each) {
  return each != 0 && count > all / each ? 0 : take(count * each, alignment); /* is zero, as it came */
}

void* realloc(void* old, size_t wanted) {
  void* place = malloc(wanted);
  if (old == 0 || place == 0) return place;
  require_mine(old);
  memcpy(place, old, *size_of(old) < wanted ? *size_of(old) : wanted);
  free(old);
  return place;
}

void* memalign(size_t aligned, size_t wanted) { return take(wanted, aligned < alignment ? alignment : aligned); }
void* aligned_alloc(size_t aligned, size_t wanted) { return memalign(aligned, wanted); }
int posix_memalign(void** place, size_t aligned, size_t wanted) {
  *place = memalign(aligned, wanted);
  return *place != 0 ? 0 : ENOMEM;
}
size_t malloc_usable_size(void* place) { return place != 0 ? *size_of(place) : 0; }
