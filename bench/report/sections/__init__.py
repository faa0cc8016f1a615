"""Sections of report.md and details.md: functions of a run and its pictures' names that write Markdown.

``bench.report.page`` has their order. A section without anything to say is empty.
"""
