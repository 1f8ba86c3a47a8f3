"""`footscan lasts ...`: the library of shoelasts; each group of commands has a file of its own."""

import typer

from footscan.cli.lasts_customise import add_customise_command
from footscan.cli.lasts_export import add_export_commands
from footscan.cli.lasts_fit import add_fit_commands
from footscan.cli.lasts_library import add_library_commands

lasts_app = typer.Typer(help="Shoelasts: library, matching, customising, export.", no_args_is_help=True)
add_library_commands(lasts_app)
add_fit_commands(lasts_app)
add_customise_command(lasts_app)
add_export_commands(lasts_app)
