# SPDX-License-Identifier: Apache-2.0
"""Contexts, and the one way in which functions of the library are called: errors become exceptions, messages go to
Python's logging, Ctrl-C and exceptions of callbacks end the call."""
from __future__ import annotations

import atexit
import ctypes
import logging
import os
import signal
import sys
import threading
import time
import weakref
from typing import Any, Optional

from . import _declarations as c
from ._errors import Error, make_error
from ._library import lib, make_struct
from ._settings import apply_settings, documented

_logger = logging.getLogger("nephos")
_levels = {c.NEPH_LOG_ERROR: logging.ERROR, c.NEPH_LOG_WARNING: logging.WARNING, c.NEPH_LOG_INFO: logging.INFO,
           c.NEPH_LOG_DEBUG: logging.DEBUG}


# ---- Messages ----

_all_messages = weakref.WeakSet()


class _Messages:
    """Error messages of the calls in progress. Messages of the library's own threads belong to all of them."""

    def __init__(self):
        self.lock = threading.Lock()
        self.calls = {}  # thread to a stack of lists of messages
        _all_messages.add(self)

    def begin(self):
        messages = []
        with self.lock:
            self.calls.setdefault(threading.get_ident(), []).append(messages)
        return messages

    def end(self):
        with self.lock:
            stack = self.calls[threading.get_ident()]
            stack.pop()
            if not stack:
                del self.calls[threading.get_ident()]

    def add(self, message):
        with self.lock:
            own = self.calls.get(threading.get_ident())
            for stack in [own] if own else self.calls.values():
                stack[-1].append(message)


def _make_log(messages):
    def receive(_, level, text):
        message = text.decode("utf-8", "replace")
        if level == c.NEPH_LOG_ERROR:
            messages.add(message)
        else:
            _logger.log(_levels.get(level, logging.DEBUG), "%s", message)

    return c.neph_log_fn(receive)


# ---- Ctrl-C ----

_watches = []  # calls of the main thread, the innermost last
_running = set()  # calls of all threads


def _note_interrupt(number, frame):
    for watch in _watches:
        watch.is_interrupted = True


class _Interrupts:
    """Signals during a call of the main thread. Ctrl-C is noted, and raised when the call has ended. Handlers of programs
    stay in place; an exception of theirs that comes before the first line of a callback reaches sys.unraisablehook."""

    def __init__(self, watch):
        self.watch = watch
        self.is_main = threading.current_thread() is threading.main_thread()
        self.previous = None
        self.hook = None

    def catch(self, unraisable):
        watch = getattr(unraisable.object, "__self__", None)
        if isinstance(watch, Watch):
            watch.exception = watch.exception or unraisable.exc_value
        else:
            self.hook(unraisable)

    def __enter__(self):
        if not self.is_main:
            return
        _watches.append(self.watch)
        self.hook, sys.unraisablehook = sys.unraisablehook, self.catch
        if signal.getsignal(signal.SIGINT) is signal.default_int_handler:
            self.previous = signal.signal(signal.SIGINT, _note_interrupt)

    def __exit__(self, *_):
        if not self.is_main:
            return
        if self.previous is not None:
            signal.signal(signal.SIGINT, self.previous)
        sys.unraisablehook = self.hook
        _watches.remove(self.watch)


# ---- Calls ----

class Progress:
    """Progress of a call: `stage`, a few words; `fraction`, 0 to 1; `elapsed_s`; `remaining_s`, infinite at first."""

    __slots__ = ("stage", "fraction", "elapsed_s", "remaining_s")

    def __init__(self, struct):
        self.stage = struct.stage.decode("utf-8", "replace")
        self.fraction, self.elapsed_s, self.remaining_s = struct.fraction, struct.elapsed_s, struct.remaining_s

    def __repr__(self):
        return "<nephos.Progress %s, %.0f %%>" % (self.stage, 100 * self.fraction)


class Watch:
    """One call of the library with its callbacks."""

    def __init__(self, progress=None):
        if progress is not None and not callable(progress):
            raise TypeError("progress is %r, must be a function of one argument" % (progress,))
        self.progress = progress
        self.messages = None  # those of the context
        self.is_interrupted = False
        self.is_at_exit = False
        self.exception = None
        self.function = c.neph_progress_fn(self._report)

    def attach(self, desc):
        """Sets the progress callback of a description."""
        desc.progress = self.function
        return desc

    @property
    def is_stopped(self):
        return self.is_interrupted or self.is_at_exit or self.exception is not None

    def ask(self, function, *arguments):
        """Calls a function of the program; returns whether the call of the library continues (None: yes)."""
        if self.is_stopped:
            return False
        try:
            answer = function(*arguments)
            return answer is None or bool(answer)
        except BaseException as exception:  # it is raised again when the call has ended
            self.exception = exception
            return False

    def _report(self, _, progress):
        if self.progress is None:
            return not self.is_stopped
        return self.ask(lambda: self.progress(Progress(progress.contents)))

    def call(self, context, name, *arguments):
        """Calls a function that returns neph_result, and raises its error."""
        context.check_process()
        self.messages = context._messages
        messages = self.messages.begin()
        _running.add(self)
        try:
            with _Interrupts(self):
                result = getattr(lib, name)(*arguments)
        finally:
            _running.discard(self)
            self.messages.end()
        if self.is_at_exit:
            raise SystemExit  # which ends a thread without a message
        if self.exception:
            raise self.exception
        if self.is_interrupted:
            raise KeyboardInterrupt
        if result:
            raise make_error(result, messages, lib.neph_result_get_text(result).decode())


def _make_interrupt(messages):
    """Function that ends the waits of a context's calls for other processes, once one of the calls is stopped."""
    def is_interrupted(_):
        return any(watch.is_stopped for watch in list(_running) if watch.messages is messages)

    return c.neph_interrupt_fn(is_interrupted)


@atexit.register
def _end_calls():
    """Ends the calls of daemon threads before the interpreter shuts down."""
    end = time.monotonic() + 5
    while _running and time.monotonic() < end:
        for watch in list(_running):
            watch.is_at_exit = True
        time.sleep(0.01)


def call(context, name, *arguments):
    Watch().call(context, name, *arguments)


def create(context, kind, name, *arguments, watch=None):
    """Calls a function whose last argument receives an object; the object is destroyed where the call fails."""
    handle = kind()
    try:
        (watch or Watch()).call(context, name, *arguments, ctypes.byref(handle))
    except BaseException:
        _destroyers[kind](handle)
        raise
    return handle


def take_text(context, name, *arguments, watch=None):
    """Calls a function whose last argument receives a text."""
    text = ctypes.c_void_p()
    try:
        (watch or Watch()).call(context, name, *arguments, ctypes.byref(text))
        return ctypes.string_at(text).decode("utf-8", "replace")
    finally:
        lib.neph_text_destroy(context._handle, text)


# ---- Objects ----

_destroyers = {
    c.neph_context: lib.neph_context_destroy, c.neph_scene: lib.neph_scene_destroy,
    c.neph_image: lib.neph_image_destroy, c.neph_volume: lib.neph_volume_release,
    c.neph_renderer: lib.neph_renderer_destroy, c.neph_check: lib.neph_check_destroy,
    c.neph_report: lib.neph_report_destroy,
}


class Owner:
    """Holds an object of the library, and destroys it in the process that made it. Threads of a context do not follow a
    fork: a child would wait for them for ever."""

    __slots__ = ("handle", "context", "process", "destroy", "__weakref__")

    def __init__(self, handle, context):
        self.destroy = _destroyers[type(handle)]
        self.process = os.getpid()
        self.handle, self.context = handle, context

    def __del__(self, getpid=os.getpid):
        if self.handle and self.process == getpid():
            self.destroy(self.handle)
            self.handle = None


class Object:
    """Base of scenes, volumes, images and renderers."""

    __slots__ = ("_owner", "__weakref__")

    def __init__(self, handle, context):
        self._owner = Owner(handle, context)

    @property
    def context(self) -> Context:
        """Context to which the object belongs."""
        return self._owner.context

    @property
    def _handle(self):
        return self._owner.handle

    def __reduce__(self):
        raise TypeError("nephos.%s cannot be pickled or copied" % type(self).__name__)


class Context:
    """Threads, memory and log. Objects of one context share its threads; programs that render in several threads of
    their own give each a context: `Context(thread_count=1)`."""

    __slots__ = ("_owner", "_messages", "_log", "_interrupt")

    @documented("neph_context_create", settings="neph_context_desc")
    def __init__(self, **settings: Any) -> None:
        desc = make_struct(c.neph_context_desc)
        for name in ("log", "log_user", "reallocate", "reallocate_user"):
            if name in settings:
                raise TypeError("Context() has no setting %r: messages go to the logger \"nephos\"" % name)
        apply_settings(desc, settings, "Context()")
        self._messages = _Messages()
        self._log = desc.log = _make_log(self._messages)
        self._interrupt = desc.is_interrupted = _make_interrupt(self._messages)
        handle = c.neph_context()
        messages = self._messages.begin()
        result = lib.neph_context_create(ctypes.byref(desc), ctypes.byref(handle))
        self._messages.end()
        if result:
            raise make_error(result, messages, lib.neph_result_get_text(result).decode())
        self._owner = Owner(handle, None)
        self._owner.context = (self._log, self._interrupt)  # callbacks live as long as the context
        self._set_names()

    def _set_names(self):
        names = make_struct(c.neph_names_desc)
        texts = [b"%s=%s" % pair for pair in os.environb.items()]
        names.variables = (ctypes.c_char_p * (len(texts) + 1))(*texts, None)
        names.time_zone_dir = os.environb.get(b"TZDIR")
        call(self, "neph_context_set_names", self._handle, ctypes.byref(names))

    @property
    def _handle(self):
        return self._owner.handle

    @property
    def thread_count(self) -> int:
        """Number of threads that work for this context."""
        return lib.neph_context_get_thread_count(self._handle)

    @property
    def isa(self) -> str:
        """Instruction-set level in use, such as "x86-64-v3"."""
        return lib.neph_isa_get_name(lib.neph_context_get_isa(self._handle)).decode()

    def check_process(self) -> None:
        """Raises in a process that was forked from the one that made this context."""
        if self._owner.process != os.getpid():
            raise Error("the object was made before a fork, and its threads are not in this process: make it anew here")

    def __reduce__(self):
        raise TypeError("nephos.Context cannot be pickled or copied")


_default = None
_default_lock = threading.Lock()


def get_context(context: Optional[Context] = None) -> Context:
    """The given context, or the default one of this process."""
    global _default
    if context is not None:
        if not isinstance(context, Context):
            raise TypeError("context is %r, must be a nephos.Context" % (context,))
        return context
    with _default_lock:
        if _default is None or _default._owner.process != os.getpid():
            _default = Context()
        return _default


def _renew_locks():
    """Locks that another thread held at the fork stay locked in the child, where that thread is not."""
    global _default_lock
    _default_lock = threading.Lock()
    for messages in list(_all_messages):
        messages.lock = threading.Lock()


os.register_at_fork(after_in_child=_renew_locks)
