"""A reader who follows a page, block by block, in a folder."""

from __future__ import annotations

import ast
import contextlib
import doctest
import io
import os
import re
import shlex
import shutil
import socket
import subprocess
import sys
from dataclasses import replace
from importlib.metadata import metadata
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final, Self

from packaging.requirements import Requirement

from tests import processes
from tests.docs.background import Background
from tests.docs.kinds import KINDS
from tests.docs.transcript import Command, begins_with, commands_of, fits, lines_of
from tests.paths import ROOT

if TYPE_CHECKING:
    from tests.docs.page import Block

_PORT: Final = "7447"
_PAGE_PORT: Final = "7448"
_OURS: Final = ("hmrsim", "bt-controller")
_SHELL: Final = re.compile(r"[|&;<>$`*?~()\n]|^\w+=")
"""What only a shell understands, outside of quotes."""
_PROGRESS: Final = re.compile(r"^(?:searching: |reducing a failure of |[\d,]+ of [\d,]+ runs \().*\n", re.MULTILINE)
"""What commands report of their progress every few seconds, more often on a slow machine; no page shows it."""
_GOES_ON: Final = re.compile(r"hmrsim (?:run|view)\b")
"""Programs that go on, as in another terminal, until the page starts the next such one."""
_QUOTED: Final = re.compile(r"'[^']*'|\"[^\"$`]*\"")
_FACTOR: Final = "20"
"""How many times faster than real time the simulators of pages are."""
_PLUGINS: Final = "-p no:randomly -p no:cacheprovider -p no:xdist"
_BESIDE: Final = ("examples", "maps", "schemas")
"""What a reader has in the folder of a checkout."""


class Session:
    """The shared state of a page's blocks: folder, namespace, environment, port, and background commands."""

    def __init__(self, folder: Path, files: Path) -> None:
        self.skipped: list[str] = []
        self._files = files
        self._folder = folder
        self._at = folder
        self._ports = dict(zip((_PORT, _PAGE_PORT), _free_ports(2), strict=True))
        self._names: dict[str, Any] = {"__name__": "__main__"}
        self._tests: list[str] = []
        self._output = ""
        self._stand_ins: dict[str, str] = {}
        self._background: list[Background] = []
        self._environment = {
            **os.environ,
            "PATH": f"{Path(sys.executable).parent}:{os.environ['PATH']}:{os.defpath}",
            "BROWSER": "true",
            "HMRSIM_LOG_LEVEL": "warning",
            "HMRSIM_REAL_TIME_FACTOR": _FACTOR,
            "PYTHONUNBUFFERED": "1",
        }

    def __enter__(self) -> Self:
        for name in _BESIDE:
            (self._folder / name).symlink_to(ROOT / name)
        (self._folder / ".venv").symlink_to(sys.prefix)
        if self._files.is_dir():
            shutil.copytree(self._files, self._folder, dirs_exist_ok=True)
        return self

    def __exit__(self, *_: object) -> None:
        self._stop()

    def do(self, block: Block) -> None:
        """Do what a block says.

        Raises:
            AssertionError: It does not do what the page shows.
        """
        program = block.remarks.get("needs")
        if program and not shutil.which(program, path=self._environment["PATH"]):
            self.skipped.append(f"line {block.line} needs {program}")
            return
        text = block.text if block.language == "stand in" else self._here(block.text)
        if block.title:
            self._write(block.title, text)
        elif kind := next((kind for kind in KINDS if kind in block.remarks), None):
            KINDS[kind](block.text, self._at, block.remarks[kind])
        elif "background output" in block.remarks:
            last = self._background[-1]
            assert last.has_printed(lambda said: fits(f"...{block.text.strip()}...", self._as_shown(said))), last.text
        elif "output" in block.remarks:
            assert fits(block.text, self._output), f"printed instead:\n{self._output}"
        elif block.language in _BY_LANGUAGE:
            _BY_LANGUAGE[block.language](self, block, text)
        else:
            raise AssertionError(f"a block {block.language!r} needs a comment that says what it is")

    def end(self) -> None:
        """Run the tests that the page has defined, as pytest runs them."""
        if self._tests:
            (self._folder / "test_page.py").write_text("\n\n".join(self._tests), encoding="utf-8")
            code, output = self._ended(Command(f"python -m pytest -q {_PLUGINS} test_page.py"))
            assert code == 0, output

    def _here(self, text: str) -> str:
        for name, port in self._ports.items():
            text = text.replace(name, port)
        for name, value in self._stand_ins.items():
            text = text.replace(name, value)
        return text

    def _as_shown(self, text: str) -> str:
        for name, port in self._ports.items():
            text = text.replace(port, name)
        return text.replace(str(ROOT), ".").replace(str(self._folder), ".")

    def _write(self, name: str, text: str) -> None:
        file = self._at / name
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(text, encoding="utf-8")

    def _python(self, block: Block, text: str) -> None:
        defined = {node.name for node in ast.parse(text).body if isinstance(node, ast.FunctionDef)}
        if any(name.startswith("test_") for name in defined):
            self._tests.append(text)
            return
        printed = io.StringIO()
        # Lines of an error are those of the page.
        code = compile("\n" * block.line + text, "page", "exec")
        with self._inside(), contextlib.redirect_stdout(printed):
            exec(code, self._names)
        self._output = self._as_shown(printed.getvalue())

    def _doctest(self, block: Block, text: str) -> None:
        test = doctest.DocTestParser().get_doctest(text, self._names, "page", None, block.line)
        report = io.StringIO()
        runner = doctest.DocTestRunner(optionflags=doctest.ELLIPSIS, verbose=False)
        with self._inside():
            runner.run(test, out=report.write, clear_globs=False)
        self._names.update(test.globs)
        assert not runner.failures, report.getvalue()

    @contextlib.contextmanager
    def _inside(self) -> Any:
        """Enter the folder with its modules and environment, and restore everything afterwards."""
        modules, path, environment, folder = set(sys.modules), list(sys.path), dict(os.environ), Path.cwd()
        os.chdir(self._at)
        sys.path.insert(0, str(self._at))
        os.environ.update(self._variables("CONNECT", secure=False))
        try:
            yield
        finally:
            os.chdir(folder)
            sys.path[:] = path
            os.environ.clear()
            os.environ.update(environment)
            for name in set(sys.modules) - modules:
                file = getattr(sys.modules[name], "__file__", None) or ""
                if file.startswith(str(self._folder)):
                    del sys.modules[name]

    def _javascript(self, block: Block, text: str) -> None:
        """Run a script beside the next blocks, once it has printed something."""
        self._write("block.mjs", text)
        command = Command("node --experimental-websocket block.mjs", "...{...")
        self._commands(replace(block, remarks={"background": ""}), [command])

    def _console(self, block: Block, text: str) -> None:
        self._commands(block, commands_of(text))

    def _shell(self, block: Block, text: str) -> None:
        self._commands(block, lines_of(text))

    def _commands(self, block: Block, commands: list[Command]) -> None:
        assert commands, "there is no command"
        last = len(commands) - 1
        codes = {int(code) for code in block.remarks.get("exit", "0").split(" or ")}
        for number, command in enumerate(commands):
            if (number == last and "background" in block.remarks) or (_GOES_ON.match(command.text) and 0 in codes):
                self._begin(command)
                continue
            ended, output = self._ended(command)
            self._output = output
            expected = self._as_shown(command.output)
            assert not expected or fits(expected, output), f"$ {command.text}\nprinted instead:\n{output}"
            assert ended in codes, f"$ {command.text}\nended with {ended}:\n{output}"

    def _ended(self, command: Command) -> tuple[int, str]:
        """Run a command to its end; return its exit code, and what it printed."""
        words = command.text.split()
        if words[0] == "export":
            name, _, value = command.text.removeprefix("export ").partition("=")
            self._environment[name.strip()] = shlex.split(value)[0].replace("$PWD", str(self._at))
            return 0, ""
        if words[0] == "cd":
            self._at = (self._at / words[1]).resolve()
            return 0, ""
        if words[:2] == ["pip", "install"] and words[2].strip("'").startswith((".", "hmrsim")):
            _check_extras(words[2].strip("'").replace(".", "hmrsim", 1))
            return 0, ""
        process = self._start(command.text)
        output, _ = process.communicate()
        return process.returncode, _PROGRESS.sub("", self._as_shown(output))

    def _begin(self, command: Command) -> None:
        """Start a background command, and wait until it has printed the lines on the page."""
        program = _GOES_ON.match(command.text)
        for other in list(self._background):
            if program and other.program == program[0]:
                self._background.remove(other)
                other.stop()
        background = Background(self._start(command.text.removesuffix("&")), program[0] if program else "")
        self._background.append(background)
        expected = self._as_shown(command.output) or ("...ready ..." if program else "")
        assert background.has_printed(lambda text: begins_with(expected, self._as_shown(text))), (
            f"$ {command.text}\nprinted instead:\n{self._as_shown(background.text)}"
        )

    def _start(self, text: str) -> subprocess.Popen[str]:
        text = re.sub(r"^make (?!-)", f"make --dry-run --directory={ROOT} ", text)
        text = re.sub(r"--view(?=$|\s+-|\s*&)", f"--view {self._ports[_PAGE_PORT]}", text)
        text = re.sub(r"^hmrsim view\b", f"hmrsim view --port {self._ports[_PAGE_PORT]}", text)
        environment = self._variables(
            "LISTEN" if text.startswith("hmrsim run") else "CONNECT", secure="--secure" in text
        )
        options: dict[str, Any] = {"cwd": self._at, "env": environment, "stderr": subprocess.STDOUT}
        words = shlex.split(text) if not _SHELL.search(_QUOTED.sub("", text)) else []
        if words and words[0] in _OURS:
            return processes.start(*words, **options)
        pipes: dict[str, Any] = {"stdin": subprocess.DEVNULL, "stdout": subprocess.PIPE}
        return subprocess.Popen(["bash", "-c", text], text=True, start_new_session=True, **pipes, **options)

    def _variables(self, role: str, *, secure: bool) -> dict[str, str]:
        """Return the environment of a program that listens on the page's port, or connects to it."""
        protocol = "tls" if secure or "HMRSIM_SECURE" in self._environment else "tcp"
        return {f"HMRSIM_{role}": f"{protocol}/127.0.0.1:{self._ports[_PORT]}", **self._environment}

    def _stop(self) -> None:
        for background in reversed(self._background):
            background.stop()
        self._background.clear()


def _check_extras(requirement: str) -> None:
    """Check that the extras of a requirement exist; the package itself is installed."""
    wanted = Requirement(requirement)
    there = set(metadata(wanted.name).get_all("Provides-Extra", []))
    assert wanted.extras <= there, f"no extra {wanted.extras - there}; there are {sorted(there)}"


def _free_ports(count: int) -> list[str]:
    """Return different free ports, each of them held until the last one is found."""
    with contextlib.ExitStack() as held:
        probes = [held.enter_context(socket.socket()) for _ in range(count)]
        for probe in probes:
            probe.bind(("127.0.0.1", 0))
        return [str(probe.getsockname()[1]) for probe in probes]


def _stand_in(session: Session, block: Block, _: str) -> None:
    name, _, value = block.text.partition(" = ")
    session._stand_ins[name] = value


_BY_LANGUAGE: Final = {
    "console": Session._console,
    "js": Session._javascript,
    "python": Session._python,
    "pycon": Session._doctest,
    "run": lambda session, block, _: session._commands(block, [Command(session._here(block.text))]),
    "sh": Session._shell,
    "stand in": _stand_in,
    "stop": lambda session, *_: session._stop(),
    "text": lambda *_: None,
}
"""How a block is done, by its language."""
