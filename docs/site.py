"""Additions of ``make docs`` to the pages of this folder: README, committed report, API reference.

MkDocs calls ``on_config`` and ``on_files`` before it reads the pages, griffe calls ``Words`` on docstrings.
"""

import re
from pathlib import Path
from typing import Any

import griffe
from mkdocs.structure.files import File, Files

ROOT = Path(__file__).parents[1]
MOVED = {"README.md": "index.md", "CONTRIBUTING.md": "contributing.md", "CHANGELOG.md": "changelog.md"}
"""Pages that stand in the root of the repository, and where they stand in the site."""
REPORT = "results/amd-epyc-2-cores"
"""The committed run whose report is shown."""
STUDIES = "results/studies"
"""Tables that studies printed; the pages quote from them."""


def on_config(config: Any) -> Any:
    """Add what is generated to the navigation that mkdocs.yml writes out."""
    config.nav += [
        {"Measured": [{"A run's report": "report.html"}, *(f"studies/{path.name}" for path in studies())]},
        {"Reference": [f"reference/{name}.md" for name in reference()]},
    ]
    return config


def on_files(files: Files, config: Any) -> Files:
    """Add the generated pages to those of the folder."""
    made = {target: moved((ROOT / source).read_text("utf-8")) for source, target in MOVED.items()}
    made |= {f"reference/{name}.md": text for name, text in reference().items()}
    made |= {f"studies/{path.name}": moved(path.read_text("utf-8")) for path in studies()}
    made["report.html"] = report()
    for source in ("LICENSE", "CITATION.cff", f"{REPORT}/overview.svg"):
        made[source] = (ROOT / source).read_text("utf-8")
    for uri, content in made.items():
        files.append(File.generated(config, uri, content=content))
    for file in files.documentation_pages():
        if file.src_uri not in made and file.abs_src_path:
            file.content_string = moved(Path(file.abs_src_path).read_text("utf-8"))
    return files


def moved(text: str) -> str:
    """A page's text with its links leading to where those files stand in the site."""
    text = re.sub(r"\]\(docs/", "](", text)
    text = re.sub(rf"\]\((?:\.\./)?{REPORT}/(report|details)\.(md|html)[^)]*\)", "](report.html)", text)
    for source, target in MOVED.items():
        text = re.sub(rf"\]\((?:\.\./)?{re.escape(source)}", f"]({target}", text)
    text = re.sub(rf"\]\((?:\.\./)?{STUDIES}/", "](studies/", text)
    # A name of a test would make a table wider than the window; shorter ones are not cut (site.css).
    text = re.sub(r"(`[^`\n]{60,}`)(?= \|)", r"\1{ .long }", text)
    # A folder or a file of the source has no page; its name says where it is.
    sources = r"(?:\.\./)?(?:results|alloc|bench|tests)(?:/[^)]*)?"
    return re.sub(rf"(?<!!)\[([^\]]*)\]\({sources}\)", r"\1", text)


def report() -> str:
    """The committed report as the page that ``thrustbench report`` makes of its record."""
    from bench.report.html import html
    from bench.report.page import details, page
    from bench.results.machines import read_machines

    machines = read_machines([ROOT / REPORT])
    run = machines[0].run
    return html(machines, page(run, frozenset()), details(run, frozenset()))


def studies() -> list[Path]:
    """The files of tables, by name."""
    return sorted((ROOT / STUDIES).glob("*.md"))


def reference() -> dict[str, str]:
    """A page for each package, with what it exports and no more, and one for the columns of results.csv."""
    from bench.results.columns import documentation

    options = "    options:\n      show_root_heading: false\n"
    pages = {name: f"# {name}\n\n::: {name}\n{options}" for name in ("alloc", "alloc.plugin", "bench")}
    return pages | {"columns": f"# Columns of results.csv\n\n{documentation()}"}


class Words(griffe.Extension):
    """Says that what stands behind a colon in this project's docstrings is a meaning; types are annotated."""

    def on_object(self, *, obj: griffe.Object, **_: Any) -> None:
        """Put each meaning on a line of its own, as NumPy's style wants it where no type is given."""
        if obj.docstring:
            text = re.sub(r"^([\w, ]+) : (?=\S)", r"\1\n    ", obj.docstring.value, flags=re.MULTILINE)
            obj.docstring.value = text
