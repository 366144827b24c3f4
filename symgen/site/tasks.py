"""Work in processes: at most so many at once, what takes times alone; what ends a process is a line, not an end."""

from __future__ import annotations

import contextlib
import multiprocessing
import os
import signal
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from multiprocessing.connection import Connection, wait
from multiprocessing.process import BaseProcess
from typing import Any, NoReturn

from symgen.console import one_line
from symgen.errors import NotSupportedError, SymgenError, ToolError

Say = Callable[[str], None]


@dataclass(frozen=True)
class Task:
    """Something to do in a process of its own: ``call(say)``, whose result is pickled."""

    name: str
    call: Callable[[Say], Any]
    alone: bool = False


@dataclass(frozen=True)
class Outcome:
    """What became of a task: its value, or why there is none."""

    value: Any = None
    refused: str = ""
    failed: str = ""


Done = Callable[[Task, Outcome], Sequence[Task]]
"""Told of every outcome; gives the tasks that can start because of it."""


def outcome_of(call: Callable[[Say], Any], say: Say) -> Outcome:
    """What became of a call: missing tools and what symgen does not do are refusals, whatever else breaks a failure."""
    try:
        return Outcome(call(say))
    except (NotSupportedError, ToolError) as error:
        return Outcome(refused=one_line(str(error)))
    except SymgenError as error:
        return Outcome(failed=one_line(str(error)))
    except Exception as error:
        if os.environ.get("SYMGEN_DEBUG"):
            raise
        return Outcome(failed=one_line(f"unexpected {type(error).__name__}: {error}"))


def _ended(_number: int, _frame: object) -> NoReturn:
    raise SystemExit(143)


def _work(task: Task, channel: Connection) -> None:
    """In the process: Ctrl-C is the parent's to hear."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    signal.signal(signal.SIGTERM, _ended)

    def say(what: str) -> None:
        channel.send(what)

    channel.send(outcome_of(task.call, say))
    channel.close()


@dataclass
class _Running:
    task: Task
    process: BaseProcess
    channel: Connection


def run(tasks: Sequence[Task], jobs: int, done: Done, say: Callable[[Task, str], None]) -> None:
    """Run all tasks and those that follow from them. Whatever interrupts this ends the processes first."""
    ready, running = list(tasks), list[_Running]()
    try:
        while ready or running:
            for task in _startable(ready, [r.task for r in running], jobs):
                ready.remove(task)
                running.append(_start(task))
                say(task, "")
            for ended, outcome in _listen(running, say):
                running.remove(ended)
                ready.extend(done(ended.task, outcome))
    finally:
        _stop(running)


def _startable(ready: Sequence[Task], running: Sequence[Task], jobs: int) -> list[Task]:
    """What takes times waits until everything else is done, and then runs alone."""
    if any(task.alone for task in running):
        return []
    together = [task for task in ready if not task.alone]
    if together or running:
        return together[: max(jobs - len(running), 0)]
    return list(ready[:1])


def _start(task: Task) -> _Running:
    here, there = multiprocessing.Pipe(duplex=False)
    process = multiprocessing.Process(target=_work, args=(task, there))
    process.start()
    there.close()
    return _Running(task, process, here)


def _listen(running: Sequence[_Running], say: Callable[[Task, str], None]) -> Iterator[tuple[_Running, Outcome]]:
    """Wait for news; those that ended."""
    heard = wait([r.channel for r in running])
    for one in list(running):
        if one.channel not in heard:
            continue
        try:
            news = one.channel.recv()
        except EOFError:
            one.process.join()
            news = Outcome(failed=f"its process ended with status {one.process.exitcode}")
        if isinstance(news, Outcome):
            one.process.join()
            one.channel.close()
            yield one, news
        else:
            say(one.task, str(news))


def _stop(running: Sequence[_Running]) -> None:
    for one in running:
        with contextlib.suppress(OSError):
            one.process.terminate()
    for one in running:
        one.process.join(5)
        if one.process.is_alive():
            one.process.kill()
            one.process.join()
