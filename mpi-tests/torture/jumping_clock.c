/* A clock that jumps: preloaded, every other look at the time of day is a day late. Clocks that only run forward are left alone. */
#define _GNU_SOURCE
#include <dlfcn.h>
#include <stdatomic.h>
#include <time.h>

int clock_gettime(clockid_t clock, struct timespec *time) {
    static _Atomic unsigned looks;
    int code = ((__typeof__(&clock_gettime))dlsym(RTLD_NEXT, "clock_gettime"))(clock, time);
    if (code == 0 && clock == CLOCK_REALTIME && atomic_fetch_add(&looks, 1) % 2) time->tv_sec += 86400;
    return code;
}
