"""`make bench-gap`: measure the diagnosis; what is done is kept, and the next run goes on. So does
one in a fresh clone, from what is published.

python -m analysis.gap_bench run --minutes 30
python -m analysis.gap_bench table
python -m analysis.gap_bench publish
"""

from __future__ import annotations

import argparse
import json
import sys
from pathlib import Path

from analysis.gap_bench.cases import all_cases
from analysis.gap_bench.count import lines
from analysis.gap_bench.page import confusions, limits_table, table
from analysis.gap_bench.published import document, go_on, keep, published
from analysis.gap_bench.run import Place, latest, read_limits, read_results, run_bench
from foundation.cores import cores
from foundation.errors import InputError
from foundation.jobs import PROCESSES

OUT = Path("camtruth-out/gap-bench")
USUAL = Place(out=OUT)


def main() -> int:
    """Run what the words ask for."""
    parser = argparse.ArgumentParser(prog="python -m analysis.gap_bench", description=__doc__)
    parser.add_argument("what", choices=["run", "limits", "table", "publish"])
    parser.add_argument("--out", type=Path, default=OUT)
    parser.add_argument("--width", type=int, default=USUAL.width)
    parser.add_argument("--height", type=int, default=USUAL.height)
    parser.add_argument("--frames", type=int, default=USUAL.frames)
    parser.add_argument("--seed", type=int, default=USUAL.seed, help="of cameras, noise and order")
    parser.add_argument("--cases", type=int, help="only the first so many")
    parser.add_argument("--kind", choices=["null", "effect", "withheld", "pair"])
    parser.add_argument("--case", help="only this one, as in effect:vignetting_excess:8:2")
    parser.add_argument("--minutes", type=float, help="begin no case after so many")
    parser.add_argument("--workers", type=int, default=cores(), help="cases at once; one a core")
    parser.add_argument(
        "--scheduler", default=PROCESSES, help="of a cluster; processes here if not"
    )
    parser.add_argument("--no-unfitted", action="store_true", help="leave out nulls uncalibrated")
    parser.add_argument("--results", type=Path, help="file of cases; the latest by default")
    options = parser.parse_args()
    place = Place(
        out=options.out,
        width=options.width,
        height=options.height,
        frames=options.frames,
        seed=options.seed,
    )
    try:
        if options.what in ("run", "limits"):
            path = published(place.size, place.seed)
            if known := go_on(place, path):
                print(f"{known} cases stand in {path}", flush=True)
            rows = run_bench(
                place,
                count=0 if options.what == "limits" else options.cases,
                kind=options.kind,
                case=options.case,
                unfitted=not options.no_unfitted,
                minutes=options.minutes,
                workers=options.workers,
                scheduler=options.scheduler,
                say=lambda words: print(words, flush=True),
            )
        if options.what == "run" and options.case:
            print(json.dumps(rows, indent=1))
        elif options.what == "limits":
            print(limits_table(read_limits(place.limits)))
        else:
            show(place, options.results or latest(place), options.what == "publish")
    except InputError as error:
        print(f"bench: error: {error}", file=sys.stderr)
        return 2
    return 0


def show(place: Place, results: Path | None, publish: bool) -> None:
    """Print the table of a file of results, and keep it for the documentation where asked."""
    path = results or place.results
    rows = read_results(path) if path.is_file() or not publish else []
    limits = read_limits(place.limits)
    done = [row for row in rows if "skipped" not in row]
    print(
        f"{len(done)} cases diagnosed and {len(rows) - len(done)} that cannot be, of"
        f" {len(all_cases())}; captures of {place.size}\n"
    )
    print(table(lines(rows, limits)))
    print(confusions(rows))
    if publish:
        print(f"{keep(document(place, rows, path.stem))} written")


if __name__ == "__main__":
    sys.exit(main())
