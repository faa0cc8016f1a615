"""``thrustbench check``."""

import click


@click.command()
@click.argument("vehicle", metavar="VEHICLE.yaml")
@click.option("--json", "as_json", is_flag=True, help="One JSON object instead of a table.")
def command(vehicle: str, as_json: bool) -> int:
    """Lint a vehicle file: errors (exit code 2), warnings, and what was taken for granted."""
    from alloc.lint.check import check_vehicle
    from alloc.lint.text import as_table, to_json

    report = check_vehicle(vehicle)
    click.echo(to_json(report) if as_json else as_table(report))
    errors = [finding for finding in report.findings if finding.level == "error"]
    if errors:
        place = f"line {errors[0].line}: " if errors[0].line else ""
        more = f" (and {len(errors) - 1} more)" if len(errors) > 1 else ""
        file = str(report.path).replace("\n", " ")
        click.echo(f"thrustbench: {file}: {place}{errors[0].message}{more}", err=True)
        return 2
    return 0
