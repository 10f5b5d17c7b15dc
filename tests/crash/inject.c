/* Fails, kills or stops a run at its k-th call that writes below a folder: LD_PRELOAD=inject.so, for Linux with glibc.

The settings, and the counter that all processes of a run share, are in a small file that RSEGEN_CRASH_CONTROL names
and that every process maps into memory: `struct control` below, `Control` in tests/crash/injection.py. Only calls of
processes in `group`, and of paths below `root`, are counted. With k = 0 they are only counted.

Not seen are writes by the C library itself (fprintf, fputs; fwrite is), by mmap, and io_uring; rsegen uses none. */

#define _GNU_SOURCE
#include <dlfcn.h>
#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <signal.h>
#include <stdarg.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/file.h>
#include <sys/mman.h>
#include <sys/sendfile.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <sys/uio.h>
#include <unistd.h>

#define FILES 4096
enum mode { COUNT, KILL, KILLAFTER, FAIL, FULL, SHORT, INTERRUPT, STOP, STUCK, DEAD };
enum verdict { PASS, FAILS, THEN_DIE, HALF };

struct control {
    int32_t group;        /* the process group that is counted; 0: none */
    int32_t main;         /* the process that gets SIGINT */
    int32_t mode;         /* enum mode */
    int32_t error;        /* errno of FAIL, STUCK and DEAD */
    int32_t alone;        /* kill only the process that makes the call, not its group */
    int32_t no_locks;     /* flock and fcntl's locks fail with ENOLCK */
    int32_t no_exchange;  /* renameat2 with flags, such as RENAME_EXCHANGE, fails with this errno */
    int32_t full;         /* set by FULL: the disk is full from now on */
    int32_t cut;          /* set by SHORT: the next write fails */
    int32_t busy;         /* a lock on `unsynced` */
    int32_t every;        /* STUCK: each so many-th of the renames from the k-th call on fails */
    int32_t renames;      /* the renames from the k-th call on */
    int64_t k;
    int64_t calls;
    int64_t by_workers;   /* those of other processes than `main` */
    int64_t files;        /* how many of `unsynced` are used */
    struct { uint64_t inode; int64_t size; } unsynced[FILES]; /* files, with what the disk is sure to have of them */
    char call[32];        /* the k-th call, and its path */
    char path[1024];
    char root[1024];
};

static struct control *control;

__attribute__((constructor)) static void map_control(void) {
    const char *path = getenv("RSEGEN_CRASH_CONTROL");
    int file = path ? (int)syscall(SYS_openat, AT_FDCWD, path, O_RDWR | O_CLOEXEC) : -1;
    if (file < 0) return;
    void *map = mmap(NULL, sizeof *control, PROT_READ | PROT_WRITE, MAP_SHARED, file, 0);
    if (map != MAP_FAILED) control = map;
    close(file);
}

static void die(void) {
    kill(control->alone ? getpid() : 0, SIGKILL);
    for (;;) pause();
}

static int counted(const char *path) {
    size_t length = strlen(control->root);
    return !strncmp(path, control->root, length) && (path[length] == '/' || !path[length]);
}

static int ours(void) { return control && control->group && getpgrp() == control->group; }

/* The absolute path of a descriptor, or of a path relative to it, in `found`; whether calls with it are counted. */
static int below(int folder, const char *path, char *found) {
    char link[64];
    ssize_t length = 0;
    if (!ours()) return 0;
    int before = errno;
    if (!path || path[0] != '/') {
        if (folder == AT_FDCWD) snprintf(link, sizeof link, "/proc/self/cwd");
        else snprintf(link, sizeof link, "/proc/self/fd/%d", folder);
        length = readlink(link, found, PATH_MAX - 1);
    }
    errno = before;
    if (length < 0) return 0;
    found[length] = 0;
    if (path) snprintf(found + length, (size_t)(PATH_MAX - length), "%s%s", length ? "/" : "", path);
    return counted(found);
}

/* Whether a call fails that is not the first: renames go on to fail, or all calls of a disk that is gone. */
static int goes_on(const char *call) {
    if (control->mode == DEAD) return 1;
    if (control->mode != STUCK || (strncmp(call, "rename", 6) && strcmp(call, "link"))) return 0;
    return __atomic_fetch_add(&control->renames, 1, __ATOMIC_SEQ_CST) % control->every == 0;
}

/* What happens to a call: counts it, and if it is the k-th, does what the mode says. */
static enum verdict judge(const char *call, const char *path, int allocates, int writes) {
    int64_t number = __atomic_add_fetch(&control->calls, 1, __ATOMIC_SEQ_CST);
    if (getpid() != control->main) __atomic_add_fetch(&control->by_workers, 1, __ATOMIC_SEQ_CST);
    if (writes && control->cut && number > control->k) {
        control->cut = 0;
        errno = control->error;
        return FAILS;
    }
    if (control->k && number >= control->k && goes_on(call)) {
        if (!control->call[0]) {
            snprintf(control->call, sizeof control->call, "%s", call);
            snprintf(control->path, sizeof control->path, "%s", path);
        }
        errno = control->error;
        return FAILS;
    }
    if (number == control->k && control->mode != STUCK) {
        snprintf(control->call, sizeof control->call, "%s", call);
        snprintf(control->path, sizeof control->path, "%s", path);
        switch (control->mode) {
        case KILL: die(); break;
        case KILLAFTER: return THEN_DIE;
        case FAIL: errno = control->error; return FAILS;
        case FULL: control->full = 1; break;
        case SHORT: control->cut = 1; return writes ? HALF : PASS;
        case INTERRUPT: kill(control->main, SIGINT); break;
        case STOP: kill(0, SIGSTOP); break;
        default: break;
        }
    }
    if (control->full && allocates) {
        errno = ENOSPC;
        return FAILS;
    }
    return PASS;
}

/* Files whose content the disk may lose in a power failure: from a write to the next fsync. */
static void lock_files(void) { while (__atomic_exchange_n(&control->busy, 1, __ATOMIC_ACQUIRE)) usleep(100); }
static void unlock_files(void) { __atomic_store_n(&control->busy, 0, __ATOMIC_RELEASE); }

static int64_t find_file(uint64_t inode) {
    int64_t i = 0;
    while (i < control->files && control->unsynced[i].inode != inode) i++;
    return i;
}

static void written(int file, int64_t sure) { /* sure: the size on disk, -1: as it is now */
    struct stat now;
    int before = errno;
    if (!fstat(file, &now) && S_ISREG(now.st_mode)) {
        lock_files();
        int64_t i = find_file(now.st_ino);
        if (i == control->files && i < FILES) {
            control->unsynced[i].inode = now.st_ino;
            control->unsynced[i].size = sure < 0 ? now.st_size : sure;
            control->files++;
        } else if (i < FILES && sure >= 0) control->unsynced[i].size = sure;
        unlock_files();
    }
    errno = before;
}

static void synced(int file, int all) {
    struct stat now;
    int before = errno;
    if (!fstat(file, &now)) {
        lock_files();
        int64_t i = find_file(now.st_ino);
        if (all) control->files = 0;
        else if (i < control->files) control->unsynced[i] = control->unsynced[--control->files];
        unlock_files();
    }
    errno = before;
}

#define REAL(result, name, ...) \
    static result (*real)(__VA_ARGS__); \
    if (!real) real = (result (*)(__VA_ARGS__))dlsym(RTLD_NEXT, name); \
    char path_[PATH_MAX]; \
    enum verdict verdict = PASS

#define DONE(result) \
    do { \
        __typeof__(result) value_ = (result); \
        if (verdict == THEN_DIE) die(); \
        return value_; \
    } while (0)

/* A call that names a path, and is done unless it is to fail. */
#define NAMED(name, folder, path, allocates, done) \
    if (below(folder, path, path_)) verdict = judge(name, path_, allocates, 0); \
    if (verdict == FAILS) return -1; \
    DONE(done)

int mkdir(const char *path, mode_t mode) {
    REAL(int, "mkdir", const char *, mode_t);
    NAMED("mkdir", AT_FDCWD, path, 1, real(path, mode));
}
int mkdirat(int at, const char *path, mode_t mode) {
    REAL(int, "mkdirat", int, const char *, mode_t);
    NAMED("mkdir", at, path, 1, real(at, path, mode));
}
int unlink(const char *path) { REAL(int, "unlink", const char *); NAMED("unlink", AT_FDCWD, path, 0, real(path)); }
int unlinkat(int at, const char *path, int flags) {
    REAL(int, "unlinkat", int, const char *, int);
    NAMED("unlink", at, path, 0, real(at, path, flags));
}
int rmdir(const char *path) { REAL(int, "rmdir", const char *); NAMED("rmdir", AT_FDCWD, path, 0, real(path)); }
int remove(const char *path) { REAL(int, "remove", const char *); NAMED("unlink", AT_FDCWD, path, 0, real(path)); }
int rename(const char *old, const char *new) {
    REAL(int, "rename", const char *, const char *);
    NAMED("rename", AT_FDCWD, new, 0, real(old, new));
}
int renameat(int from, const char *old, int to, const char *new) {
    REAL(int, "renameat", int, const char *, int, const char *);
    NAMED("rename", to, new, 0, real(from, old, to, new));
}
int link(const char *old, const char *new) {
    REAL(int, "link", const char *, const char *);
    NAMED("link", AT_FDCWD, new, 1, real(old, new));
}
int linkat(int from, const char *old, int to, const char *new, int flags) {
    REAL(int, "linkat", int, const char *, int, const char *, int);
    NAMED("link", to, new, 1, real(from, old, to, new, flags));
}
int symlink(const char *target, const char *path) {
    REAL(int, "symlink", const char *, const char *);
    NAMED("symlink", AT_FDCWD, path, 1, real(target, path));
}
int symlinkat(const char *target, int at, const char *path) {
    REAL(int, "symlinkat", const char *, int, const char *);
    NAMED("symlink", at, path, 1, real(target, at, path));
}
int truncate(const char *path, off_t size) {
    REAL(int, "truncate", const char *, off_t);
    NAMED("truncate", AT_FDCWD, path, 0, real(path, size));
}
int truncate64(const char *path, off64_t size) { return truncate(path, size); }

/* Whether a rename is more than rename(2) does, on a disk that cannot; a second run has the same disk. */
static int unable(unsigned flags) {
    if (flags && control && control->no_exchange) {
        errno = control->no_exchange;
        return -1;
    }
    return 0;
}

int renameat2(int from, const char *old, int to, const char *new, unsigned flags) {
    REAL(int, "renameat2", int, const char *, int, const char *, unsigned);
    if (unable(flags)) return -1;
    NAMED("renameat2", to, new, 0, real(from, old, to, new, flags));
}

long syscall(long number, ...) { /* renameat2 has a wrapper in newer C libraries only */
    long a[6];
    va_list rest;
    va_start(rest, number);
    for (int i = 0; i < 6; i++) a[i] = va_arg(rest, long);
    va_end(rest);
    REAL(long, "syscall", long, ...);
    if (number != SYS_renameat2) return real(number, a[0], a[1], a[2], a[3], a[4], a[5]);
    if (unable((unsigned)a[4])) return -1;
    NAMED("renameat2", (int)a[2], (const char *)a[3], 0, real(number, a[0], a[1], a[2], a[3], a[4], a[5]));
}

/* Opening counts if it makes or empties a file. */
static int opened(int at, const char *path, int flags, mode_t mode) {
    char path_[PATH_MAX];
    enum verdict verdict = PASS;
    int counts = (flags & (O_CREAT | O_TRUNC)) && below(at, path, path_);
    int before = errno, exists = counts && !faccessat(at, path, F_OK, AT_SYMLINK_NOFOLLOW);
    errno = before;
    if (counts) verdict = judge("open", path_, !exists, 0);
    if (verdict == FAILS) return -1;
    int file = (int)syscall(SYS_openat, at, path, flags | O_LARGEFILE, mode);
    if (file >= 0 && counts && ((flags & O_TRUNC) || !exists)) written(file, 0);
    DONE(file);
}

#define MODE \
    mode_t mode = 0; \
    if (flags & (O_CREAT | __O_TMPFILE)) { \
        va_list rest; \
        va_start(rest, flags); \
        mode = (mode_t)va_arg(rest, int); \
        va_end(rest); \
    }

int open(const char *path, int flags, ...) { MODE return opened(AT_FDCWD, path, flags, mode); }
int open64(const char *path, int flags, ...) { MODE return opened(AT_FDCWD, path, flags, mode); }
int openat(int at, const char *path, int flags, ...) { MODE return opened(at, path, flags, mode); }
int openat64(int at, const char *path, int flags, ...) { MODE return opened(at, path, flags, mode); }
int creat(const char *path, mode_t mode) {
    return opened(AT_FDCWD, path, O_CREAT | O_WRONLY | O_TRUNC, mode);
}
int creat64(const char *path, mode_t mode) { return creat(path, mode); }

/* A write to a descriptor: `half` is what is done of it if it is cut short. */
#define WRITTEN(name, file, allocates, half, done) \
    int counts = below(file, NULL, path_); \
    if (counts) verdict = judge(name, path_, allocates, 1); \
    if (verdict == FAILS) return -1; \
    if (counts) written(file, -1); \
    if (verdict == HALF) return half; \
    DONE(done)

ssize_t write(int file, const void *data, size_t size) {
    REAL(ssize_t, "write", int, const void *, size_t);
    WRITTEN("write", file, 1, real(file, data, (size + 1) / 2), real(file, data, size));
}
ssize_t pwrite(int file, const void *data, size_t size, off_t at) {
    REAL(ssize_t, "pwrite", int, const void *, size_t, off_t);
    WRITTEN("write", file, 1, real(file, data, (size + 1) / 2, at), real(file, data, size, at));
}
ssize_t pwrite64(int file, const void *data, size_t size, off64_t at) { return pwrite(file, data, size, at); }
ssize_t writev(int file, const struct iovec *parts, int count) {
    REAL(ssize_t, "writev", int, const struct iovec *, int);
    WRITTEN("write", file, 1, real(file, parts, (count + 1) / 2), real(file, parts, count));
}
ssize_t pwritev(int file, const struct iovec *parts, int count, off_t at) {
    REAL(ssize_t, "pwritev", int, const struct iovec *, int, off_t);
    WRITTEN("write", file, 1, real(file, parts, (count + 1) / 2, at), real(file, parts, count, at));
}
ssize_t sendfile(int file, int from, off_t *at, size_t size) {
    REAL(ssize_t, "sendfile", int, int, off_t *, size_t);
    WRITTEN("write", file, 1, real(file, from, at, (size + 1) / 2), real(file, from, at, size));
}
ssize_t sendfile64(int file, int from, off64_t *at, size_t size) { return sendfile(file, from, (off_t *)at, size); }
ssize_t copy_file_range(int from, off64_t *start, int file, off64_t *at, size_t size, unsigned flags) {
    REAL(ssize_t, "copy_file_range", int, off64_t *, int, off64_t *, size_t, unsigned);
    WRITTEN("write", file, 1, real(from, start, file, at, (size + 1) / 2, flags),
            real(from, start, file, at, size, flags));
}
int ftruncate(int file, off_t size) {
    REAL(int, "ftruncate", int, off_t);
    WRITTEN("truncate", file, 0, real(file, size), real(file, size));
}
int ftruncate64(int file, off64_t size) { return ftruncate(file, size); }

size_t fwrite(const void *data, size_t size, size_t count, FILE *stream) {
    REAL(size_t, "fwrite", const void *, size_t, size_t, FILE *);
    int file = fileno(stream), counts = file >= 0 && below(file, NULL, path_);
    if (counts) verdict = judge("write", path_, 1, 1);
    if (verdict == FAILS) return 0;
    if (counts) written(file, -1);
    DONE(real(data, size, verdict == HALF ? count / 2 : count, stream));
}

#define SYNCED(name, file, all, done) \
    int counts = below(file, NULL, path_); \
    if (counts) verdict = judge(name, path_, 0, 0); \
    if (verdict == FAILS) return -1; \
    int result = done; \
    if (counts && !result) synced(file, all); \
    DONE(result)

int fsync(int file) { REAL(int, "fsync", int); SYNCED("fsync", file, 0, real(file)); }
int fdatasync(int file) { REAL(int, "fdatasync", int); SYNCED("fsync", file, 0, real(file)); }
int syncfs(int file) { REAL(int, "syncfs", int); SYNCED("syncfs", file, 1, real(file)); }

/* A disk of a network without locks; a second run has the same disk. */
int flock(int file, int operation) {
    REAL(int, "flock", int, int);
    if (control && control->no_locks) { errno = ENOLCK; return -1; }
    DONE(real(file, operation));
}

static int controlled(int file, int command, void *argument) {
    REAL(int, "fcntl64", int, int, ...);
    int locks = command == F_SETLK || command == F_SETLKW || command == F_OFD_SETLK || command == F_OFD_SETLKW;
    if (locks && control && control->no_locks) { errno = ENOLCK; return -1; }
    DONE(real(file, command, argument));
}

int fcntl(int file, int command, ...) {
    va_list rest;
    va_start(rest, command);
    void *argument = va_arg(rest, void *);
    va_end(rest);
    return controlled(file, command, argument);
}
int fcntl64(int file, int command, ...) {
    va_list rest;
    va_start(rest, command);
    void *argument = va_arg(rest, void *);
    va_end(rest);
    return controlled(file, command, argument);
}
