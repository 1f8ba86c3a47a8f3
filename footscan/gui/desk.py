"""The desk: one thread changes the state of the page, one other does what takes long; browsers only post."""

import logging
import queue
import threading
from collections.abc import Callable
from dataclasses import replace
from typing import Any, TypeVar

from footscan.errors import CancelledError, FootscanError
from footscan.gui import texts
from footscan.gui.readiness import tidy_memory
from footscan.gui.state import Job, PageState

Command = Callable[[], None]
Tell = Callable[[str, str, bool], None]
"""Title, body, and whether something went wrong: said to whoever controls."""
Progress = Callable[[int, int], None]
Made = TypeVar("Made")
_LOG = logging.getLogger(__name__)


class Desk:
    """Commands are done one after the other, in the order in which they came.

    Attributes:
        state: What the page shows; replaced, never changed.
        stop: Switches lasers and motor off, at once; any thread.
    """

    def __init__(self, tell: Tell, stop: Command = lambda: None) -> None:
        self.stop = stop
        self.state = PageState()
        self._tell = tell
        self._commands: queue.Queue[Command | None] = queue.Queue()
        self._jobs: queue.Queue[Command | None] = queue.Queue()
        self._listeners: list[Callable[[PageState], None]] = []
        self._cancelled = threading.Event()
        self._stop_job: Command = lambda: None
        self._threads = [
            threading.Thread(name="desk", target=self._work, args=(self._commands, lambda: None), daemon=True),
            threading.Thread(name="jobs", target=self._work, args=(self._jobs, tidy_memory), daemon=True),
        ]

    def start(self) -> None:
        """Let both threads run."""
        for thread in self._threads:
            thread.start()

    def close(self) -> None:
        """End both threads once their queues are empty; safe to call twice."""
        for waiting, thread in ((self._jobs, self._threads[1]), (self._commands, self._threads[0])):
            waiting.put(None)
            if thread.is_alive():
                thread.join(30.0)

    @property
    def idle(self) -> bool:
        """Nothing is done or waits on either thread, and nothing follows from what was done."""
        return not any(each.unfinished_tasks for each in (self._jobs, self._commands, self._jobs))

    def listen(self, show: Callable[[PageState], None]) -> None:
        """Call this with every new state, on the desk's thread."""
        self._listeners.append(show)

    def post(self, command: Command) -> None:
        """Do this on the desk's thread, soon; any thread."""
        self._commands.put(command)

    def change(self, **values: Any) -> None:
        """Replace parts of the state and show it; on the desk's thread only."""
        self.state = replace(self.state, **values)
        for show in self._listeners:
            show(self.state)

    def say(self, title: str, body: str, wrong: bool = False) -> None:
        """Tell whoever controls."""
        self._tell(title, body, wrong)

    def job(
        self,
        words: str,
        work: Callable[[Progress], Made],
        then: Callable[[Made], None],
        failed: Callable[[FootscanError], None] | None = None,
        stop: Command = lambda: None,
        *,
        keeps_nothing: bool = False,
    ) -> bool:
        """Do something long on the other thread; False when something else is running.

        Args:
            words: What it is, for the progress bar.
            work: Called with a progress callback, on the jobs' thread.
            then: Called with what was made, on the desk's thread.
            failed: Called with a refusal, on the desk's thread; None only says it.
            stop: Called when somebody cancels, at once; work that tells its progress is stopped there in any case.
            keeps_nothing: The work only computes: what it makes is left when somebody cancelled meanwhile.
        """
        if self.state.job is not None:
            self.say(texts.WORKING, texts.BUSY, wrong=True)
            return False
        self._cancelled.clear()
        self._stop_job = stop
        self.change(job=Job(words))
        self._jobs.put(lambda: self._do(words, work, then, failed, keeps_nothing))
        return True

    def cancel(self) -> None:
        """Stop what is running, as soon as it can be; any thread."""
        if self.state.job is not None:
            self._cancelled.set()
            self._stop_job()
            self.post(self._say_cancelling)  # some work ends only where its next step would begin

    def _do(
        self,
        words: str,
        work: Callable[[Progress], Made],
        then: Callable[[Made], None],
        failed: Callable[[FootscanError], None] | None,
        keeps_nothing: bool,
    ) -> None:
        told = Job(words)

        def tell(done: int, total: int) -> None:
            nonlocal told
            if self._cancelled.is_set():
                raise CancelledError(texts.CANCELLED.format(what=words))
            if told != Job(words, done, total):  # work may ask often whether somebody cancelled
                told = Job(words, done, total)
                self.post(lambda now=told: self._progress(now))

        try:
            made = work(tell)
            if keeps_nothing:
                tell(told.done, told.total)
        except FootscanError as err:
            self.post(lambda err=err: self._end(lambda: self._failed(err, failed)))
        except Exception as err:  # noqa: BLE001 - the page goes on, and says so
            _LOG.exception("job %r", words)
            what = type(err).__name__
            self.post(lambda: self._end(lambda: self.say(texts.FAILED, texts.INTERNAL.format(what=what), wrong=True)))
        else:
            self.post(lambda: self._end(lambda: then(made)))

    def _say_cancelling(self) -> None:
        job = self.state.job
        if job is not None and self._cancelled.is_set():
            self.change(job=replace(job, words=texts.CANCELLING))

    def _progress(self, job: Job) -> None:
        if self.state.job is not None:
            self.change(job=job)

    def _end(self, command: Command) -> None:
        self.change(job=None)
        command()

    def _failed(self, err: FootscanError, failed: Callable[[FootscanError], None] | None) -> None:
        if failed is None and isinstance(err, CancelledError):
            self.say(str(err), "")
        elif failed is None:
            self.say(texts.FAILED, str(err), wrong=True)
        else:
            failed(err)

    def _work(self, waiting: "queue.Queue[Command | None]", afterwards: Command) -> None:
        while (command := waiting.get()) is not None:
            try:
                command()
            except FootscanError as err:
                self.say(texts.FAILED, str(err), wrong=True)
            except Exception as err:  # noqa: BLE001 - one command must not end the page
                _LOG.exception("command of the page")
                self.say(texts.FAILED, texts.INTERNAL.format(what=type(err).__name__), wrong=True)
            command = None  # what it made may be large
            afterwards()
            waiting.task_done()
