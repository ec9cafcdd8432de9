"""`camtruth verify`: is a folder still what it was when it was made?"""

from __future__ import annotations

from pathlib import Path

import click

from camtruth import options, terminal


@click.command()
@click.argument("folder", type=options.PATH)
@options.as_json
def command(folder: Path, as_json: bool) -> None:
    """Check every file of FOLDER against its checksum.

    FOLDER is anything that a command of camtruth wrote. Exit code 0 when every file is what
    SHA256SUMS says; 2, with one line that names the file, for a flipped bit, a missing or cut
    file, and one that does not belong there.
    """
    from foundation.verification import verify

    with terminal.progress("checking") as advance:
        whole = verify(folder, advance)
    if as_json:
        terminal.print_json(
            {
                "format": "camtruth-verify/1",
                "verdict": "whole",
                "files": whole.files,
                "bytes": whole.size_bytes,
            }
        )
        return
    click.echo(f"{folder}: whole, {whole.files} files of {whole.size_bytes} bytes")
