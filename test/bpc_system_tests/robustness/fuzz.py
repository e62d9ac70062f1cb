"""A fuzzer with a fixed corpus: input n of a seed is always the same.

As a script: ``python -m bpc_system_tests.robustness.fuzz --executions 1000000 --seed 1``; or
guided by coverage where atheris is installed: ``... --guided bag``. Each target runs in its own
process, so that a target that dies or hangs is reported with the number of the input.
"""

from __future__ import annotations

import argparse
from collections import Counter
from importlib import import_module
import logging
import mmap
import multiprocessing
import os
from pathlib import Path
import random
import resource
import struct
import sys
import tempfile
import time
import traceback
from typing import Any

PATIENCE_S = 30.0  # for one input
MAX_GROWTH_BYTES = 256e6  # of memory, beyond what reading the seeds takes
NUMBERS = (0, 1, -1, 7, 255, 2**15, 2**16, 2**31 - 1, 2**31, 2**32 - 1, 2**60, 2**63 - 1)
WORDS = (b'.nan', b'.inf', b'1e999', b'-0', b'[]', b'{}', b'&a ', b'*a', b'[*a, *a]',
         b'!!python/object/apply:os.system [id]', b'!!binary x', b'!!set {}', b'2024-99-99',
         b'0x', b'1:2:3', b'9' * 400, b'9' * 5000, b'\n', b'\n  ', b'\t', b'\0', b'"', b"'",
         b': ', b',', b'- ', b'? ', b'<<: ', b'|\n', b'#', b'true', b'null', b'~', b'\xff\xfe',
         b'[' * 50, b'[' * 2000, b'{a: ' * 500, b'../../etc/passwd', b'%s%n', b'\xe2\x80\xa8')


def spoil(seeds: list[bytes], text: bool, chance: random.Random) -> bytes:
    """Return a spoiled copy of one of the seeds.

    Args:
        seeds: good inputs.
        text: whether to insert words instead of numbers.
        chance: source of all choices.
    """
    data = bytearray(chance.choice(seeds))
    for _ in range(chance.choice((1, 1, 1, 2, 3, 8))):
        place = chance.randrange(len(data) + 1)
        kind = chance.randrange(8)
        length = min(chance.choice((1, 1, 2, 4, 8, 40, 1000)), len(data) - place)
        if kind == 0:
            del data[place:]
        elif kind == 1:
            del data[place:place + length]
        elif kind == 2:
            data[place:place] = data[place:place + length] * chance.choice((1, 2, 50))
        elif kind == 3:
            other = chance.choice(seeds)
            begin = chance.randrange(len(other) + 1)
            data[place:place + length] = other[begin:begin + length]
        elif text and kind < 7:
            data[place:place + length] = chance.choice(WORDS)
        elif kind < 6 and length >= 2:
            size, form = chance.choice(((2, '<H'), (4, '<I'), (8, '<Q')))
            number = chance.choice(NUMBERS) + chance.randrange(-2, 3)
            data[place:place + size] = struct.pack(form, number % 256**size)
        else:
            for index in range(place, place + length):
                data[index] ^= chance.randrange(1, 256)
    return bytes(data)


def input_of(target: Any, seed: int, number: int) -> bytes:
    """Return the input of a number."""
    return spoil(target.seeds, target.text, random.Random(seed << 32 | number))


def execute(target: Any, data: bytes) -> bool:
    """Read one input; tell whether it was accepted.

    Raises:
        Exception: whatever the target should not have raised.
    """
    try:
        target.run(data)
    except target.refused:
        return False
    return True


def fuzz(name: str, seed: int, executions: int, progress: Any, outcome: Any) -> None:
    """Run a target in this process, and put the result into ``outcome``."""
    from bpc_system_tests.robustness.fuzz_targets.targets import targets

    logging.disable(logging.CRITICAL)
    # Fast CDR reports each sequence that is too long on stderr.
    os.dup2(os.open(os.devnull, os.O_WRONLY), 2)
    counts: Counter[str] = Counter()
    with tempfile.TemporaryDirectory(dir='/dev/shm') as folder:
        target = targets(Path(folder))[name]
        for data in target.seeds:
            execute(target, data)
        before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
        for number in range(executions):
            struct.pack_into('<Q', progress, 0, number)
            try:
                counts['accepted' if execute(target, input_of(target, seed, number))
                       else 'refused'] += 1
            except Exception:
                outcome.put((name, dict(counts), f'input {number} of seed {seed}:\n'
                             + traceback.format_exc(limit=-4)))
                return
        grown = (resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before) * 1024
    problem = f'memory grew by {grown / 1e6:.0f} MB' if grown > MAX_GROWTH_BYTES else ''
    counts['peak memory above seeds, MB'] = round(grown / 1e6)
    outcome.put((name, dict(counts), problem))


def run(name: str, seed: int, executions: int) -> tuple[dict[str, int], str]:
    """Fuzz a target in its own process; return counts of the results, and the problem if any."""
    context = multiprocessing.get_context('fork')
    progress = mmap.mmap(-1, 8)
    outcome = context.Queue()
    process = context.Process(target=fuzz, args=(name, seed, executions, progress, outcome))
    process.start()
    last, since = -1, time.monotonic()
    while outcome.empty() and process.is_alive():
        number = struct.unpack_from('<Q', progress)[0]
        if number != last:
            last, since = number, time.monotonic()
        elif time.monotonic() - since > PATIENCE_S:
            process.kill()
        process.join(0.05)
    try:
        _, counts, problem = outcome.get(timeout=1.0)
    except Exception:  # the process died without a result
        counts, problem = {}, (f'died with {process.exitcode} at input '
                               f'{struct.unpack_from("<Q", progress)[0]} of seed {seed}')
    process.join()
    return counts, problem


def guided(name: str, arguments: list[str]) -> None:
    """Let atheris choose the inputs by the code that they reach; it ends with its own report."""
    atheris = import_module('atheris')  # optional, not installed by ./bpc
    with atheris.instrument_imports(include=['bpc_perception', 'mcap', 'yaml', 'ticlib']):
        from bpc_system_tests.robustness.fuzz_targets.targets import targets
    logging.disable(logging.CRITICAL)
    with tempfile.TemporaryDirectory(dir='/dev/shm') as folder:
        target = targets(Path(folder))[name]
        corpus = Path(folder) / 'corpus'
        corpus.mkdir()
        for number, data in enumerate(target.seeds):
            (corpus / str(number)).write_bytes(data)
        atheris.Setup([sys.argv[0], *arguments, str(corpus)],
                      lambda data: execute(target, data) and None)
        atheris.Fuzz()


def main() -> None:
    """Fuzz all targets, fast ones with more inputs, and print the figures."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument('--executions', type=int, default=1_000_000)
    parser.add_argument('--seed', type=int, default=1)
    parser.add_argument('--target', action='append')
    parser.add_argument('--guided', metavar='TARGET')
    given, others = parser.parse_known_args()
    if given.guided:
        guided(given.guided, others)
        return
    from bpc_system_tests.robustness.fuzz_targets.targets import targets

    with tempfile.TemporaryDirectory(dir='/dev/shm') as folder:
        costs = {name: target.cost for name, target in targets(Path(folder)).items()
                 if not given.target or name in given.target}
    share = given.executions / sum(1 / cost for cost in costs.values())
    failed = False
    for name, cost in costs.items():
        begin = time.monotonic()
        executions = round(share / cost)
        counts, problem = run(name, given.seed, executions)
        failed |= bool(problem)
        print(f'{name}: {executions} in {time.monotonic() - begin:.0f} s, {counts} {problem}',
              flush=True)
    sys.exit(failed)


if __name__ == '__main__':
    main()
