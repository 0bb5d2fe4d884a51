"""The command line of the fuzzers."""

import argparse
import json
from collections.abc import Callable
from typing import Any


def run_fuzzer(fuzz: Callable[[int, int], dict[str, Any]], description: str | None) -> None:
    """Fuzz and print the figures. fuzz : number of datagrams, seed -> figures"""
    parser = argparse.ArgumentParser(description=description, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--datagrams", type=int, default=1_000_000)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--json", action="store_true")
    options = parser.parse_args()
    result = fuzz(options.datagrams, options.seed)
    print(json.dumps(result) if options.json else "\n".join(f"{name:33} {value}" for name, value in result.items()))
