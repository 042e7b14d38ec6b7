/* A disk that sickens and a clock that jumps, for one process: preloaded into it, steered by a file of 64 bytes that it maps.
 *
 * Byte 0: state of the disk. 0 well, 'r' read-only (EROFS), 'e' every write fails (EIO), 's' synchronising fails (EIO),
 * 'f' full (ENOSPC). Bytes 8 to 15: seconds by which the wall clock is wrong. SICK_CONTROL names the file, SICK_DISK the
 * folder that is ill. What is done to a mapping of memory is not seen here.
 */
#define _GNU_SOURCE
#include <dlfcn.h>
#include <errno.h>
#include <fcntl.h>
#include <stdarg.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <sys/uio.h>
#include <time.h>
#include <unistd.h>

static volatile unsigned char *control;
static const char *disk;

__attribute__((constructor)) static void begin(void) {
  const char *path = getenv("SICK_CONTROL");
  int (*open_file)(const char *, int, ...) = dlsym(RTLD_NEXT, "open");
  int file = path ? open_file(path, O_RDONLY | O_CLOEXEC) : -1;
  if (file < 0) return;
  void *mapped = mmap(NULL, 64, PROT_READ, MAP_SHARED, file, 0);
  close(file);
  disk = getenv("SICK_DISK");
  if (mapped != MAP_FAILED) control = mapped;
}

static int state(void) { return control ? control[0] : 0; }

/* The fault of a write in the state there is, or 0. */
static int of_writing(void) {
  switch (state()) {
    case 'r': return EROFS;
    case 'e': return EIO;
    case 'f': return ENOSPC;
    default: return 0;
  }
}

static int ill(const char *path) { return disk && strncmp(path, disk, strlen(disk)) == 0; }

/* Only files: pipes, sockets and the log are well. */
static int ill_file(int file) {
  struct stat found;
  if (file <= 2 || of_writing() == 0 || fstat(file, &found) != 0) return 0;
  return S_ISREG(found.st_mode);
}

#define NEXT(name) ((__typeof__(&name))dlsym(RTLD_NEXT, #name))
#define FAIL(fault) do { errno = (fault); return -1; } while (0)

#define OPEN(name)                                                                              \
  int name(const char *path, int flags, ...) {                                                  \
    va_list rest;                                                                               \
    va_start(rest, flags);                                                                      \
    mode_t mode = (flags & (O_CREAT | O_TMPFILE)) ? va_arg(rest, mode_t) : 0;                   \
    va_end(rest);                                                                               \
    int makes = (flags & O_CREAT) && access(path, F_OK) != 0;                                   \
    int writes = (flags & O_ACCMODE) != O_RDONLY;                                               \
    /* A full or failing disk still opens what is there. */                                     \
    if (ill(path) && of_writing() && (makes || (writes && state() == 'r'))) FAIL(of_writing()); \
    return NEXT(name)(path, flags, mode);                                                       \
  }
OPEN(open)
OPEN(open64)

#define WRITE(name, ...)                          \
  { if (ill_file(file)) FAIL(of_writing()); return NEXT(name)(__VA_ARGS__); }
ssize_t write(int file, const void *from, size_t count) WRITE(write, file, from, count)
ssize_t writev(int file, const struct iovec *from, int count) WRITE(writev, file, from, count)
ssize_t pwrite(int file, const void *from, size_t count, off_t at) WRITE(pwrite, file, from, count, at)
ssize_t pwrite64(int file, const void *from, size_t count, off64_t at) WRITE(pwrite64, file, from, count, at)
int ftruncate(int file, off_t length) WRITE(ftruncate, file, length)
int ftruncate64(int file, off64_t length) WRITE(ftruncate64, file, length)

#define SYNC(name)                                                        \
  int name(int file) {                                                    \
    if (state() == 's' || state() == 'e') FAIL(EIO);                      \
    return NEXT(name)(file);                                              \
  }
SYNC(fsync)
SYNC(fdatasync)

#define ON_PATH(name, path, ...) \
  { if (ill(path) && state() != 'f' && of_writing()) FAIL(of_writing()); return NEXT(name)(__VA_ARGS__); }
int mkdir(const char *path, mode_t mode) ON_PATH(mkdir, path, path, mode)
/* A failing disk still forgets names. */
int unlink(const char *path) {
  if (ill(path) && state() == 'r') FAIL(EROFS);
  return NEXT(unlink)(path);
}
int rename(const char *from, const char *to) ON_PATH(rename, from, from, to)

int clock_gettime(clockid_t which, struct timespec *now) {
  int failed = NEXT(clock_gettime)(which, now);
  if (failed == 0 && control && (which == CLOCK_REALTIME || which == CLOCK_REALTIME_COARSE)) {
    int64_t wrong_s;
    memcpy(&wrong_s, (const void *)(control + 8), sizeof wrong_s);
    now->tv_sec += wrong_s;
  }
  return failed;
}
