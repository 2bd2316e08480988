/* SPDX-License-Identifier: Apache-2.0 */
#include "image/picture_sandbox.h"

#include <errno.h>
#include <linux/audit.h>
#include <linux/filter.h>
#include <linux/seccomp.h>
#include <stddef.h>
#include <stdio.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/syscall.h>
#include <unistd.h>

#include "core/mapped_bytes.h"

/* ---- Limits ---- */

static void lower(int resource, struct rlimit limit, uint64_t wanted) {
  if (wanted < limit.rlim_cur) limit.rlim_cur = wanted; /* RLIM_INFINITY is the largest number */
  (void)setrlimit((__rlimit_resource_t)resource, &limit);
}

void np_picture_sandbox_limit(const np_picture_sandbox *sandbox, uint64_t room_bytes, uint64_t seconds) {
  lower(RLIMIT_AS, sandbox->memory, sandbox->mapped_bytes + room_bytes);
  lower(RLIMIT_CPU, sandbox->time, seconds);
}

/* ---- Filter ---- */

#if defined(__x86_64__) && defined(SYS_seccomp)

/* Refused calls: a decoder needs only memory, its threads, its input and its output. */
static const unsigned refused[] = {SYS_open,
                                   SYS_openat,
                                   SYS_open_by_handle_at,
                                   SYS_creat,
                                   SYS_memfd_create,
                                   SYS_socket,
                                   SYS_connect,
                                   SYS_bind,
                                   SYS_socketpair,
                                   SYS_execve,
                                   SYS_execveat,
                                   SYS_fork,
                                   SYS_vfork,
                                   SYS_ptrace,
                                   SYS_process_vm_readv,
                                   SYS_kill,
                                   SYS_process_vm_writev,
                                   SYS_tkill,
                                   SYS_tgkill,
                                   SYS_unlink,
                                   SYS_unlinkat,
                                   SYS_rename,
                                   SYS_renameat,
                                   SYS_renameat2,
                                   SYS_link,
                                   SYS_linkat,
                                   SYS_symlink,
                                   SYS_symlinkat,
                                   SYS_mkdir,
                                   SYS_mkdirat,
                                   SYS_rmdir,
                                   SYS_mknod,
                                   SYS_mknodat,
                                   SYS_chmod,
                                   SYS_fchmodat,
                                   SYS_chown,
                                   SYS_fchownat,
                                   SYS_truncate,
                                   SYS_ftruncate,
                                   SYS_bpf,
                                   SYS_perf_event_open,
                                   SYS_mount,
                                   SYS_keyctl,
                                   SYS_add_key,
                                   SYS_io_uring_setup,
                                   SYS_userfaultfd,
                                   SYS_shmget,
                                   SYS_shmat};

/* Numbers of instructions before the list of calls, and after it. */
enum { REFUSED = sizeof refused / sizeof *refused, HEAD = 7, TAIL = 2, FILTER = HEAD + REFUSED + TAIL };
enum { ALLOW_AT = HEAD + REFUSED, REFUSE_AT, X32_BIT = 0x40000000 };

#define LOAD(field) (struct sock_filter) BPF_STMT(BPF_LD | BPF_W | BPF_ABS, offsetof(struct seccomp_data, field))

/* A comparison with a number, which jumps from instruction `at` to one of two others. */
static struct sock_filter jump(unsigned short comparison, unsigned number, int at, int if_true, int if_false) {
  return (struct sock_filter){(unsigned short)(BPF_JMP | comparison | BPF_K), (unsigned char)(if_true - at - 1),
                              (unsigned char)(if_false - at - 1), number};
}

/* Builds the filter. prlimit is allowed for this process, which is 0 in the call. */
static void fill_filter(struct sock_filter f[FILTER]) {
  f[0] = LOAD(arch);
  f[1] = jump(BPF_JEQ, AUDIT_ARCH_X86_64, 1, 2, REFUSE_AT);
  f[2] = LOAD(nr);
  f[3] = jump(BPF_JGE, X32_BIT, 3, REFUSE_AT, 4);
  f[4] = jump(BPF_JEQ, SYS_prlimit64, 4, 5, HEAD);
  f[5] = LOAD(args[0]);
  f[6] = jump(BPF_JEQ, 0, 6, ALLOW_AT, REFUSE_AT);
  for (int i = 0; i < REFUSED; i++) f[HEAD + i] = jump(BPF_JEQ, refused[i], HEAD + i, REFUSE_AT, HEAD + i + 1);
  f[ALLOW_AT] = (struct sock_filter)BPF_STMT(BPF_RET | BPF_K, SECCOMP_RET_ALLOW);
  f[REFUSE_AT] = (struct sock_filter)BPF_STMT(BPF_RET | BPF_K, SECCOMP_RET_ERRNO | EPERM);
}

static void install_filter(void) {
  struct sock_filter filter[FILTER];
  const struct sock_fprog program = {FILTER, filter};
  fill_filter(filter);
  if (prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0)) return;
  (void)syscall(SYS_seccomp, SECCOMP_SET_MODE_FILTER, SECCOMP_FILTER_FLAG_TSYNC, &program);
}

#else

static void install_filter(void) { (void)prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0); }

#endif

np_picture_sandbox np_picture_sandbox_begin(void) {
  static const struct rlimit nothing = {0, 0};
  np_picture_sandbox sandbox = {.mapped_bytes = np_mapped_bytes_get()};
  (void)getrlimit(RLIMIT_AS, &sandbox.memory);
  (void)getrlimit(RLIMIT_CPU, &sandbox.time);
  (void)setrlimit(RLIMIT_CORE, &nothing);
  (void)setrlimit(RLIMIT_FSIZE, &nothing);
  (void)setrlimit(RLIMIT_NOFILE, &nothing);
  install_filter();
  return sandbox;
}
