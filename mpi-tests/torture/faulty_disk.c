/* A disk that fails: preloaded, it lets a number of bytes be written to files of one folder, by all processes together, and
 * refuses the rest.
 *
 * FAULT_FOLDER  text in the paths of the files that it holds
 * FAULT_SPARED  text in the paths of files that it always takes
 * FAULT_STATE   file of 16 bytes, shared by the processes: bytes written so far, bytes there is room for (int64 each)
 * FAULT_ERROR   number of the error (errno) of what is refused
 * FAULT_SLOW    microseconds that each write takes longer
 */
#define _GNU_SOURCE
#include <dlfcn.h>
#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/uio.h>
#include <unistd.h>

struct state {
    _Atomic long long written;
    long long room;
};

static struct state *shared(void) {
    static struct state *state;
    if (!state) {
        const char *path = getenv("FAULT_STATE");
        int file = path ? open(path, O_RDWR) : -1;
        if (file >= 0) {
            void *map = mmap(NULL, sizeof *state, PROT_READ | PROT_WRITE, MAP_SHARED, file, 0);
            state = map == MAP_FAILED ? NULL : map;
            close(file);
        }
    }
    return state;
}

static int is_held(int file) {
    char link[64], path[PATH_MAX];
    snprintf(link, sizeof link, "/proc/self/fd/%d", file);
    ssize_t length = readlink(link, path, sizeof path - 1);
    const char *folder = getenv("FAULT_FOLDER");
    if (length <= 0 || !folder || !shared()) return 0;
    path[length] = 0;
    const char *spared = getenv("FAULT_SPARED");
    return path[0] == '/' && strstr(path, folder) && !(spared && strstr(path, spared));
}

/* Bytes of `wanted` there is room for; -1 with errno set if there is none. */
static ssize_t granted(int file, size_t wanted) {
    if (wanted == 0 || !is_held(file)) return (ssize_t)wanted;
    const char *slow = getenv("FAULT_SLOW");
    if (slow) usleep((useconds_t)atoi(slow));
    struct state *state = shared();
    long long before = atomic_fetch_add(&state->written, (long long)wanted);
    long long room = state->room - before;
    if (room >= (long long)wanted) return (ssize_t)wanted;
    if (room > 0) return (ssize_t)room;
    const char *error = getenv("FAULT_ERROR");
    errno = error ? atoi(error) : ENOSPC;
    return -1;
}

#define NEXT(name) ((__typeof__(&name))dlsym(RTLD_NEXT, #name))

ssize_t write(int file, const void *bytes, size_t count) {
    ssize_t room = granted(file, count);
    return room < 0 ? -1 : NEXT(write)(file, bytes, (size_t)room);
}

ssize_t pwrite(int file, const void *bytes, size_t count, off_t at) {
    ssize_t room = granted(file, count);
    return room < 0 ? -1 : NEXT(pwrite)(file, bytes, (size_t)room, at);
}

ssize_t pwrite64(int file, const void *bytes, size_t count, off64_t at) {
    ssize_t room = granted(file, count);
    return room < 0 ? -1 : NEXT(pwrite64)(file, bytes, (size_t)room, at);
}

/* Vectors are written whole or not at all. */
static int is_granted(int file, const struct iovec *parts, int count) {
    size_t all = 0;
    for (int k = 0; k < count; k++) all += parts[k].iov_len;
    ssize_t room = granted(file, all);
    if (room == (ssize_t)all) return 1;
    if (room >= 0) errno = ENOSPC;
    return 0;
}

ssize_t writev(int file, const struct iovec *parts, int count) {
    return is_granted(file, parts, count) ? NEXT(writev)(file, parts, count) : -1;
}

ssize_t pwritev(int file, const struct iovec *parts, int count, off_t at) {
    return is_granted(file, parts, count) ? NEXT(pwritev)(file, parts, count, at) : -1;
}

ssize_t pwritev64(int file, const struct iovec *parts, int count, off64_t at) {
    return is_granted(file, parts, count) ? NEXT(pwritev64)(file, parts, count, at) : -1;
}

/* A disk without room refuses to bring anything to rest as well. */
static int is_full(int file) {
    if (!is_held(file) || atomic_load(&shared()->written) <= shared()->room) return 0;
    const char *error = getenv("FAULT_ERROR");
    errno = error ? atoi(error) : ENOSPC;
    return 1;
}

int fsync(int file) { return is_full(file) ? -1 : NEXT(fsync)(file); }

int fdatasync(int file) { return is_full(file) ? -1 : NEXT(fdatasync)(file); }
