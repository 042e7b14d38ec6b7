/* What a process holds of its heap: preloaded into it, counts bytes and blocks between malloc and free in a file that it
 * maps. Memory that the C library keeps for later is not in it, unlike in the resident size.
 *
 * HELD_COUNTERS names the file: bytes in its first eight bytes, blocks in the next, in the machine's order.
 */
#define _GNU_SOURCE
#include <dlfcn.h>
#include <fcntl.h>
#include <malloc.h>
#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <unistd.h>

struct counters {
  atomic_long bytes, blocks;
};
/* Until the file is mapped, and where there is none. */
static struct counters before;
static struct counters *counters = &before;

static void *(*real_malloc)(size_t), *(*real_calloc)(size_t, size_t), *(*real_realloc)(void *, size_t);
static void *(*real_aligned)(size_t, size_t);
static int (*real_posix)(void **, size_t, size_t);
static void (*real_free)(void *);

/* To look the real ones up may itself ask for memory: it gets some of this and never gives it back. */
static char first[4096];
static size_t first_used;

static void look_up(void) {
  if (real_malloc) return;
  real_calloc = dlsym(RTLD_NEXT, "calloc");
  real_realloc = dlsym(RTLD_NEXT, "realloc");
  real_aligned = dlsym(RTLD_NEXT, "aligned_alloc");
  real_posix = dlsym(RTLD_NEXT, "posix_memalign");
  real_free = dlsym(RTLD_NEXT, "free");
  real_malloc = dlsym(RTLD_NEXT, "malloc");
}

__attribute__((constructor)) static void begin(void) {
  look_up();
  const char *path = getenv("HELD_COUNTERS");
  int file = path ? open(path, O_RDWR | O_CLOEXEC) : -1;
  if (file < 0) return;
  void *mapped = mmap(NULL, sizeof before, PROT_READ | PROT_WRITE, MAP_SHARED, file, 0);
  close(file);
  if (mapped == MAP_FAILED) return;
  memcpy(mapped, &before, sizeof before);
  counters = mapped;
}

static void count(void *block, long sign) {
  if (!block) return;
  atomic_fetch_add_explicit(&counters->bytes, sign * (long)malloc_usable_size(block), memory_order_relaxed);
  atomic_fetch_add_explicit(&counters->blocks, sign, memory_order_relaxed);
}

static void *counted(void *block) {
  count(block, 1);
  return block;
}

void *malloc(size_t size) {
  look_up();
  return counted(real_malloc(size));
}

void *calloc(size_t many, size_t size) {
  if (!real_calloc) {
    void *block = first + first_used;
    first_used += (many * size + 15) & ~(size_t)15;
    return first_used <= sizeof first ? block : NULL;
  }
  look_up();
  return counted(real_calloc(many, size));
}

void *realloc(void *block, size_t size) {
  look_up();
  count(block, -1);
  void *moved = real_realloc(block, size);
  /* What could not be moved is still held. */
  count(moved || size == 0 ? moved : block, 1);
  return moved;
}

void *aligned_alloc(size_t alignment, size_t size) {
  look_up();
  return counted(real_aligned(alignment, size));
}

int posix_memalign(void **block, size_t alignment, size_t size) {
  look_up();
  int fault = real_posix(block, alignment, size);
  if (!fault) count(*block, 1);
  return fault;
}

void free(void *block) {
  if ((char *)block >= first && (char *)block < first + sizeof first) return;
  look_up();
  count(block, -1);
  real_free(block);
}
