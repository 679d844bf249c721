"""Pages with code and what it prints."""

import contextlib
import io
import re
from typing import Any


def run(page: str, namespace: dict[str, Any]) -> int:
    """Run each block of Python that a block of text follows, and compare; return their number."""
    pairs = re.findall(r"```python\n((?:(?!```).)*?)```\n\n[ ]*```text\n(.*?)```", page, flags=re.DOTALL)
    for code, expected in pairs:
        printed = io.StringIO()
        with contextlib.redirect_stdout(printed):
            exec(code, namespace)
        assert printed.getvalue() == expected
    return len(pairs)
