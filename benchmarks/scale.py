"""Large evaluations on Ray: seconds by rigs and workers, what a piece costs beside its work, memory, bytes.

    python -m benchmarks.scale
    python -m benchmarks.scale --sizes 1000 10000 100000 1000000 --workers 1 2

The policy is `constant`, the quickest, so that what is not its work shows most; the suite is `default`. Workers have
done pieces before they are timed. Larger clusters are reckoned, not measured.
"""

from __future__ import annotations

import tempfile
import time
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

from benchmarks.measure import kept, note, peak_memory, print_table, write_json
from drillrig_env.allowed import COUNT
from drillrig_env.command_line import Parser, command
from drillrig_env.engine import Engine, engine_at
from drillrig_env.evaluation.evaluate import evaluate
from drillrig_env.flags import of_kind

SIZES, WORKERS = (1_000, 10_000, 100_000), (1, 2)
EMPTY = 2_000  # pieces without work, by which the cost of a piece is measured
CLUSTERS = (100, 1_000)  # cores that the table is carried on to


def nothing(_piece: int) -> None:
    """A piece without work."""


def peak(_piece: int) -> int:
    """The largest memory of a worker so far, bytes."""
    time.sleep(0.2)  # so that another worker takes the next
    return peak_memory()


def empty_piece(engine: Engine) -> float:
    """Seconds that a piece costs beside its work."""
    engine.map(nothing, range(50))
    begin = time.perf_counter()
    engine.map(nothing, range(EMPTY))
    return (time.perf_counter() - begin) / EMPTY


def evaluated(engine: Engine, rigs: int) -> dict[str, float]:
    """Seconds of an evaluation of so many rigs, and bytes that it leaves on disk for each."""
    with tempfile.TemporaryDirectory(prefix="drillrig-") as folder:
        begin = time.perf_counter()
        evaluate(["constant"], rigs=rigs, engine=engine, folder=Path(folder))
        seconds = time.perf_counter() - begin
        size = sum(path.stat().st_size for path in Path(folder).rglob("*") if path.is_file())
    return {"rigs": rigs, "seconds": seconds, "bytes_a_rig": size / rigs}


def measure(sizes: Sequence[int], workers: Sequence[int]) -> Iterator[tuple[int, dict[str, Any]]]:
    """Workers and figures, one measurement after another."""
    for number in workers:
        begin = time.perf_counter()
        with engine_at("ray", number) as engine:
            yield number, {"start_s": time.perf_counter() - begin}
            evaluate(["constant"], rigs=number * 1000, engine=engine)
            yield number, {"piece_s": empty_piece(engine)}
            for rigs in sizes:
                figures = evaluated(engine, rigs)
                yield number, {f"{rigs}": {**figures, "memory_B": max(engine.map(peak, range(2 * number)))}}


def tabulate(results: dict[int, dict[str, Any]]) -> None:
    """Print the tables."""
    sizes = list(dict.fromkeys(name for found in results.values() for name in found if name.isdigit()))
    rows = []
    for size in sizes:
        cells = [f"{int(size):,}"]
        for found in results.values():
            seconds = found[size]["seconds"] if size in found else None
            if seconds is None:
                cells += ["-", "-", "-"]
            else:
                cells += [f"{seconds:.1f}", f"{int(size) / seconds:,.0f}", f"{found[size]['memory_B'] / 1e6:.0f}"]
        rows.append(cells)
    headings = [text for number in results for text in (f"{number} workers, s", "rigs/s", "MB each")]
    print_table(["rigs", *headings], rows)
    print()
    names = {"start_s": ("start of Ray, s", 1.0), "piece_s": ("a piece without work, ms", 1e3)}
    print_table(
        ["", *(f"{number} workers" for number in results)],
        [
            [title, *(f"{found[name] * scale:.3g}" if name in found else "-" for found in results.values())]
            for name, (title, scale) in names.items()
        ],
    )
    alone = results.get(1, {})
    if sizes and sizes[-1] in alone and "piece_s" in alone:
        print(f"\n{expected(alone[sizes[-1]], alone['piece_s'])}")


def expected(largest: dict[str, float], piece: float) -> str:
    """What larger clusters would do, by arithmetic: a piece's work over the cores, and its cost on the head."""
    work = largest["seconds"] / largest["rigs"] * 1000.0
    lines = [
        f"a piece of 1,000 rigs: {work:.2f} s of a core, {piece * 1e3:.2f} ms of the head, "
        f"{largest['bytes_a_rig']:.0f} bytes a rig on disk"
    ]
    for cores in CLUSTERS:
        rate, limit = cores / work, 1.0 / piece
        lines.append(
            f"{cores:,} cores: {rate:,.0f} pieces/s by their work, {limit:,.0f} by the head; 1,000,000 rigs in "
            f"{1000.0 / min(rate, limit):.1f} s at best"
        )
    return "\n".join(lines)


@command
def main(arguments: Sequence[str] | None = None) -> None:
    """Measure, and print the tables."""
    parser = Parser(prog="python -m benchmarks.scale", description=__doc__)
    add = parser.add_argument
    add("--sizes", type=of_kind(COUNT), nargs="+", default=list(SIZES), help="rigs (default: 1000 10000 100000)")
    add("--workers", type=of_kind(COUNT), nargs="+", default=list(WORKERS), help="how many at a time (default: 1 2)")
    add("--json", type=Path, default=Path("results/benchmarks/scale.json"), help="where to write the figures")
    chosen = parser.parse_args(arguments)
    results: dict[int, dict[str, Any]] = {}

    def tell() -> None:
        tabulate(results)
        write_json(chosen.json, {str(number): found for number, found in results.items()})

    with kept(chosen.json, tell):
        for number, figures in measure(chosen.sizes, chosen.workers):
            results.setdefault(number, {}).update(figures)
            note(f"{number} workers: {next(iter(figures))}")


if __name__ == "__main__":
    raise SystemExit(main())
