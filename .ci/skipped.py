"""No test is skipped everywhere: ``.ci/skipped.py FOLDER`` reads what pytest's runs left there by --junitxml.

Prints each test that no run asked, with the reason where one skipped it, and ends with 1 where there is one.
What tests/not_asked.py says is meant for every machine, and counts as asked.
"""

import subprocess
import sys
from pathlib import Path
from xml.etree import ElementTree


def asked(folder: Path) -> tuple[set[str], dict[str, str]]:
    """The tests that a run asked or that ask nothing, and of those that runs skipped the last reason."""
    done, skipped = set(), {}
    for report in sorted(folder.glob("*.xml")):
        for case in ElementTree.parse(report).iter("testcase"):
            name = f"{case.get('classname')}.{case.get('name')}"
            skip = case.find("skipped[@type='pytest.skip']")
            reason = "" if skip is None else skip.get("message", "")
            if skip is None or reason.startswith("not asked: "):
                done.add(name)
            skipped[name] = reason
    return done, skipped


def collected() -> dict[str, str]:
    """All tests below this folder, long ones too: their ids by the name that a report gives them."""
    command = [sys.executable, "-m", "pytest", "--collect-only", "-q", "-m", ""]
    printed = subprocess.run(command, check=True, stdout=subprocess.PIPE, text=True).stdout
    names = {}
    for line in printed.splitlines():
        address, bracket, parameters = line.partition("[")
        if ".py::" in address:
            module = address.replace(".py::", ".").replace("::", ".").replace("/", ".")
            names[f"{module}{bracket}{parameters}"] = line
    return names


if __name__ == "__main__":
    done, skipped = asked(Path(sys.argv[1]))
    never = sorted((id_, name) for name, id_ in collected().items() if name not in done)
    for id_, name in never:
        print(f"skipped everywhere: {id_}: {skipped.get(name, 'no run chose it')}")
    sys.exit(bool(never))
