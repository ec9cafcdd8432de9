"""The command `camtruth`: finds the commands in the folder, and keeps its word about errors.

Exit 0 on success, 2 on bad input (wrong options included) with nothing on standard output and one
line on standard error, 130 when interrupted, 1 for a fault of this program.
"""

from __future__ import annotations

import importlib
import os
import pkgutil
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import click

from foundation.errors import InputError, nearest, unknown

DEBUG_VARIABLE = "CAMTRUTH_DEBUG"
BAD_INPUT = 2
INTERRUPTED = 130
FAULT = 1


class Interrupted(Exception):  # noqa: N818  reads as what it is
    """Ctrl-C, under a name that click does not answer with an empty line."""


class Commands(click.Group):
    """Every file in `camtruth/commands/` is a command of that name, read when it is asked for.

    A dash in the name of a command is an underscore in that of its file, and what Python keeps for
    itself has one at its end: `import_.py` is the command `import`.
    """

    def files(self) -> dict[str, str]:
        """Modules of the commands by name."""
        folder = Path(__file__).parent / "commands"
        names = (module.name for module in pkgutil.iter_modules([str(folder)]))
        return {name.rstrip("_").replace("_", "-"): name for name in names}

    def list_commands(self, ctx: click.Context) -> list[str]:
        """The commands, in alphabetical order."""
        return sorted(self.files())

    def get_command(self, ctx: click.Context, cmd_name: str) -> click.Command | None:
        """The command of that name, if there is one."""
        file = self.files().get(cmd_name)
        if file is None:
            return None
        module = importlib.import_module(f"camtruth.commands.{file}")
        command: click.Command = module.command
        return command

    def resolve_command(
        self, ctx: click.Context, args: list[str]
    ) -> tuple[str | None, click.Command | None, list[str]]:
        """The command that the first argument names.

        Raises:
            InputError: when there is none.
        """
        name = args[0]
        command = self.get_command(ctx, name)
        if command is None:
            if name.startswith("-"):
                ctx.fail(f"No such option: {name}")
            raise unknown("command", name, self.list_commands(ctx), InputError)
        return name, command, args[1:]

    def invoke(self, ctx: click.Context) -> Any:
        """Run the command.

        Raises:
            Interrupted: when the user has had enough.
        """
        try:
            return super().invoke(ctx)
        except KeyboardInterrupt:
            raise Interrupted from None


def _print_version(ctx: click.Context, _: click.Parameter, wanted: bool) -> None:
    if wanted and not ctx.resilient_parsing:
        from importlib.metadata import version

        click.echo(version("camtruth"))
        ctx.exit()


@click.group(
    cls=Commands,
    context_settings={"help_option_names": ["-h", "--help"], "max_content_width": 100},
    no_args_is_help=False,
    invoke_without_command=True,
)
@click.option(
    "--version",
    is_flag=True,
    is_eager=True,
    expose_value=False,
    callback=_print_version,
    help="Print the version and exit.",
)
@click.pass_context
def camtruth(ctx: click.Context) -> None:
    """Synthetic camera frames with known noise, and what an estimator makes of them.

    Start with 'camtruth demo'. Every command explains itself with --help.
    """
    if ctx.invoked_subcommand is None:
        click.echo(ctx.get_help())


def main(arguments: Sequence[str] | None = None) -> int:
    """Run a command line and return its exit code."""
    try:
        camtruth.main(
            args=list(sys.argv[1:] if arguments is None else arguments),
            prog_name="camtruth",
            standalone_mode=False,
        )
    except InputError as error:
        return _say(str(error), BAD_INPUT)
    except click.UsageError as error:
        return _say(str(usage(error)), BAD_INPUT)
    except click.exceptions.Exit as leave:
        return leave.exit_code
    except (Interrupted, KeyboardInterrupt, click.Abort):
        return _say("interrupted; nothing half-written was left behind; run it again", INTERRUPTED)
    except BrokenPipeError:
        # The reader of our output has gone. Python would complain once more while shutting down.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return FAULT
    except OSError as problem:
        if problem.filename is None:
            return _fault(problem)
        found = InputError(
            f"cannot use {problem.filename} ({problem.strerror or problem})",
            "expected a path that can be",
            "check it, its length and its permissions",
        )
        return _say(str(found), BAD_INPUT)
    except Exception as fault:
        return _fault(fault)
    return 0


def _fault(fault: Exception) -> int:
    """One line for what is no fault of the user."""
    if os.environ.get(DEBUG_VARIABLE):
        raise fault
    return _say(
        f"{type(fault).__name__} ({fault}); expected none, this is a fault of camtruth;"
        f" run it again with {DEBUG_VARIABLE}=1 and report what it prints",
        FAULT,
    )


def _say(message: str, code: int) -> int:
    print("camtruth: error:", " ".join(message.split()), file=sys.stderr)
    return code


def usage(error: click.UsageError) -> InputError:
    """A wrong command line in our three parts: found, expected, remedy."""
    path = error.ctx.command_path if error.ctx else "camtruth"
    look = f"see '{path} --help'"
    if isinstance(error, click.NoSuchOption):
        options = _options(error.ctx)
        return InputError(
            f"unknown option '{error.option_name}' of '{path}'",
            f"expected one of {', '.join(options)}",
            nearest(error.option_name, options),
        )
    if isinstance(error, click.MissingParameter):
        name = error.param.human_readable_name if error.param else "an argument"
        name = error.param.opts[0] if isinstance(error.param, click.Option) else name
        return InputError(f"'{path}' without {name}", f"expected {name}", look)
    if isinstance(error, click.BadParameter) and error.param is not None:
        name = error.param.opts[0] if isinstance(error.param, click.Option) else ""
        name = name or error.param.human_readable_name
        expected = _expected(error.param.type)
        return InputError(f"{name}: {_plain(error.message)}", expected, look)
    return InputError(f"'{path}': {_plain(error.message)}", "expected a known command line", look)


def _options(ctx: click.Context | None) -> list[str]:
    if ctx is None:
        return ["--help"]
    return sorted(name for p in ctx.command.get_params(ctx) for name in p.opts if name[:2] == "--")


def _expected(kind: click.ParamType[Any]) -> str:
    if isinstance(kind, click.Choice):
        return f"expected one of {', '.join(map(str, kind.choices))}"
    if isinstance(kind, (click.IntRange, click.FloatRange)):
        number = "a whole number" if isinstance(kind, click.IntRange) else "a number"
        least = "above" if kind.min_open else "of at least"
        most = "below" if kind.max_open else "at most"
        ends = [f"{least} {kind.min:g}"] if kind.min is not None else []
        ends += [f"{most} {kind.max:g}"] if kind.max is not None else []
        return f"expected {number} {' and '.join(ends)}"
    return f"expected {kind.name}"


def _plain(message: str) -> str:
    text = message.strip().rstrip(".")
    return text[:1].lower() + text[1:]
