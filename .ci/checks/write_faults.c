/* Library for LD_PRELOAD: counts the calls that change or open files of one folder, and makes chosen ones fail.
 *
 * WRITE_FAULTS_FOLDER is the folder, an absolute path. WRITE_FAULTS_CONTROL is a file of `struct control` that all processes
 * share, so that the count goes on in the next process. The program must call the C library dynamically: system calls without
 * it are not seen. Writes to memory of a mapped file (-shm) cannot fail in this way.
 */
#define _GNU_SOURCE
#include <dlfcn.h>
#include <errno.h>
#include <fcntl.h>
#include <signal.h>
#include <stdarg.h>
#include <stdatomic.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/uio.h>
#include <time.h>
#include <unistd.h>

#define LOG_BYTES 65536

enum call { OPEN = 1, WRITE, SYNC, TRUNCATE, UNLINK, RENAME };
enum kind { IO_ERROR, NO_SPACE, TORN, KILL };

struct control {
    _Atomic uint64_t calls;    /* counted calls */
    _Atomic uint64_t of;       /* the call and file (as in `log`) of which one fails first */
    _Atomic uint64_t seen;     /* calls of that kind */
    _Atomic uint64_t first;    /* which of them fails, from 1; 0: none */
    _Atomic uint64_t span_ns;  /* how long all later calls fail, too; 0: they succeed */
    _Atomic uint64_t kind;     /* enum kind */
    _Atomic uint64_t failed;   /* calls that failed */
    _Atomic uint64_t until_ns; /* end of the fault, by the monotonic clock; 0: it has not begun */
    _Atomic uint64_t next;     /* whether the next call fails in any case */
    /* Call and file of each: the low four bits are enum call, the others 0 database, 1 -wal, 2 -shm, 3 -journal, 4 folder. */
    uint8_t log[LOG_BYTES];
};

static struct control *control;
static const char *folder;
static size_t folder_length;

#define REAL(name) ((__typeof__(&name))dlsym(RTLD_NEXT, #name))

__attribute__((constructor)) static void begin(void) {
    const char *path = getenv("WRITE_FAULTS_CONTROL");
    folder = getenv("WRITE_FAULTS_FOLDER");
    if (!path || !folder) return;
    folder_length = strlen(folder);
    int file = REAL(open64)(path, O_RDWR);
    if (file < 0) return;
    void *mapped = mmap(NULL, sizeof(struct control), PROT_READ | PROT_WRITE, MAP_SHARED, file, 0);
    close(file);
    if (mapped != MAP_FAILED) control = mapped;
}

static int ends_with(const char *text, const char *end) {
    size_t all = strlen(text), part = strlen(end);
    return all >= part && strcmp(text + all - part, end) == 0;
}

static uint64_t now_ns(void) {
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return (uint64_t)now.tv_sec * 1000000000u + (uint64_t)now.tv_nsec;
}

/* What a call must do: 0 succeed, an error number, or HALF of its bytes, HALF_AND_DIE to end the process then. */
enum { HALF = -1, HALF_AND_DIE = -2 };

static int fault(enum call call, const char *path) {
    if (!control || strncmp(path, folder, folder_length) != 0) return 0;
    uint64_t number = atomic_fetch_add(&control->calls, 1);
    unsigned file = ends_with(path, "-wal") ? 1 : ends_with(path, "-shm") ? 2 : ends_with(path, "-journal") ? 3
                  : strcmp(path + folder_length, "") == 0 || strcmp(path + folder_length, "/") == 0 ? 4 : 0;
    uint8_t name = (uint8_t)(call | file << 4);
    if (number < LOG_BYTES) control->log[number] = name;
    uint64_t kind = atomic_load(&control->kind);
    int torn = 0;
    if (name == atomic_load(&control->of) && atomic_fetch_add(&control->seen, 1) + 1 == atomic_load(&control->first)) {
        atomic_store(&control->until_ns, now_ns() + atomic_load(&control->span_ns));
        if (kind == TORN && call == WRITE) {
            torn = HALF;
            /* A program that continues at the missing half must learn the reason. */
            atomic_store(&control->next, 1);
        } else if (kind == KILL && call == WRITE) {
            torn = HALF_AND_DIE;
        } else if (kind == KILL) {
            atomic_fetch_add(&control->failed, 1);
            kill(getpid(), SIGKILL);
        }
    } else if (!atomic_exchange(&control->next, 0) && now_ns() >= atomic_load(&control->until_ns)) {
        return 0;
    }
    atomic_fetch_add(&control->failed, 1);
    return torn ? torn : kind == IO_ERROR ? EIO : ENOSPC;
}

static int fault_at(enum call call, int descriptor) {
    char link[40], path[4096];
    if (!control) return 0;
    snprintf(link, sizeof link, "/proc/self/fd/%d", descriptor);
    ssize_t length = readlink(link, path, sizeof path - 1);
    if (length < 0) return 0;
    path[length] = 0;
    return fault(call, path);
}

#define FAIL_ON(number)                     \
    do {                                    \
        int error_number = (number);        \
        if (error_number > 0) {             \
            errno = error_number;           \
            return -1;                      \
        }                                   \
    } while (0)

#define OPENS(name)                                                    \
    int name(const char *path, int flags, ...) {                       \
        va_list rest;                                                  \
        va_start(rest, flags);                                         \
        int mode = flags & O_CREAT ? va_arg(rest, int) : 0;            \
        va_end(rest);                                                  \
        FAIL_ON(fault(OPEN, path));                                    \
        return REAL(name)(path, flags, mode);                          \
    }
OPENS(open)
OPENS(open64)

#define OPENS_AT(name)                                                 \
    int name(int at, const char *path, int flags, ...) {               \
        va_list rest;                                                  \
        va_start(rest, flags);                                         \
        int mode = flags & O_CREAT ? va_arg(rest, int) : 0;            \
        va_end(rest);                                                  \
        FAIL_ON(fault(OPEN, path));                                    \
        return REAL(name)(at, path, flags, mode);                      \
    }
OPENS_AT(openat)
OPENS_AT(openat64)

/* The body of a function that writes `count` bytes or parts by `real`, which uses `length`. */
#define WRITES(file, count, real)                                       \
    int found = fault_at(WRITE, file);                                  \
    FAIL_ON(found);                                                     \
    size_t length = found < 0 ? (count) / 2 : (count);                  \
    ssize_t written = real;                                             \
    if (found == HALF_AND_DIE) kill(getpid(), SIGKILL);                 \
    return written

ssize_t write(int file, const void *bytes, size_t count) {
    WRITES(file, count, REAL(write)(file, bytes, length));
}
ssize_t pwrite(int file, const void *bytes, size_t count, off_t at) {
    WRITES(file, count, REAL(pwrite)(file, bytes, length, at));
}
ssize_t pwrite64(int file, const void *bytes, size_t count, off64_t at) {
    WRITES(file, count, REAL(pwrite64)(file, bytes, length, at));
}
ssize_t writev(int file, const struct iovec *parts, int count) {
    WRITES(file, (size_t)count, REAL(writev)(file, parts, (int)length));
}
int fsync(int file) { FAIL_ON(fault_at(SYNC, file)); return REAL(fsync)(file); }
int fdatasync(int file) { FAIL_ON(fault_at(SYNC, file)); return REAL(fdatasync)(file); }
int ftruncate(int file, off_t size) { FAIL_ON(fault_at(TRUNCATE, file)); return REAL(ftruncate)(file, size); }
int ftruncate64(int file, off64_t size) { FAIL_ON(fault_at(TRUNCATE, file)); return REAL(ftruncate64)(file, size); }
int unlink(const char *path) { FAIL_ON(fault(UNLINK, path)); return REAL(unlink)(path); }
int rename(const char *from, const char *to) { FAIL_ON(fault(RENAME, from)); return REAL(rename)(from, to); }
