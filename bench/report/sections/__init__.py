"""One file, one section of report.md or details.md, with ``section(run, drawn)`` that writes its Markdown.

``bench.report.page`` has their order. A section without anything to say is empty.
"""
