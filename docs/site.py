"""What ``make docs`` adds to the pages of this folder: the README, the committed report, an API reference.

MkDocs calls ``on_config`` and ``on_files`` before it reads the pages, griffe calls ``Words`` on docstrings.
"""

import re
from fnmatch import fnmatch
from pathlib import Path
from typing import Any

import griffe
from mkdocs.structure.files import File, Files

ROOT = Path(__file__).parents[1]
MOVED = {"README.md": "index.md", "CONTRIBUTING.md": "contributing.md", "CHANGELOG.md": "changelog.md"}
"""Pages that stand in the root of the repository, and where they stand in the site."""
REPORT = "results/amd-epyc-2-cores"
"""The committed run whose report is shown."""
GROUPS = {
    "Use": (
        "your-vehicle.md",
        "results.md",
        "scripts.md",
        "embedded.md",
        "board-*.md",
        "rivals.md",
        "gate.md",
        "suite.md",
    ),
    "Understand": (
        "exact.md",
        "loss.md",
        "theory.md",
        "method.md",
        "solvers.md",
        "cross-*.md",
        "glossary.md",
    ),
    "Extend": ("add-*.md", "contributing.md", "changelog.md"),
}
"""Pages by what they are for; a page that no pattern fits stands under More, so none is left out."""


def on_config(config: Any) -> Any:
    """Make the navigation of the pages that there are."""
    pages = sorted([*(path.name for path in (ROOT / "docs").glob("*.md")), *list(MOVED.values())[1:]])
    grouped = {
        title: [page for pattern in patterns for page in pages if fnmatch(page, pattern)]
        for title, patterns in GROUPS.items()
    }
    known = {page for group in grouped.values() for page in group}
    grouped["More"] = [page for page in pages if page not in known]
    grouped["Reference"] = [f"reference/{name}.md" for name in reference()]
    config.nav = [
        {"What limits cost": "index.md"},
        {"A report": "report.html"},
        *({title: group} for title, group in grouped.items() if group),
    ]
    return config


def on_files(files: Files, config: Any) -> Files:
    """Add the generated pages to those of the folder."""
    made = {target: moved((ROOT / source).read_text("utf-8")) for source, target in MOVED.items()}
    made |= {f"reference/{name}.md": text for name, text in reference().items()}
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


def reference() -> dict[str, str]:
    """A page for what each package exports, and one for each of its rooms with all that stands in it."""
    options = "    options:\n      show_root_heading: false\n"
    pages = {}
    for package in ("alloc", "bench"):
        pages[package] = f"# {package}\n\n::: {package}\n{options}"
        for room in sorted((ROOT / package).glob("*/__init__.py")):
            name = f"{package}.{room.parent.name}"
            pages[name] = f"# {name}\n\n::: {name}\n{options}      show_submodules: true\n"
    return pages


class Words(griffe.Extension):
    """Says that what stands behind a colon in this project's docstrings is a meaning; types are annotated."""

    def on_object(self, *, obj: griffe.Object, **_: Any) -> None:
        """Put each meaning on a line of its own, as NumPy's style wants it where no type is given."""
        if obj.docstring:
            text = re.sub(r"^([\w, ]+) : (?=\S)", r"\1\n    ", obj.docstring.value, flags=re.MULTILINE)
            obj.docstring.value = text
