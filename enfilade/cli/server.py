"""``enfilade server``: a real Neo4j with its Browser on this machine, without Docker, root or a system Java."""

from __future__ import annotations

import click

from enfilade.cli.terminal import ERR, OUT, progress_bars
from enfilade.server import USER, ServerStatus, Settings, start, status, stop


@click.group("server")
def server_command() -> None:
    """Run a real Neo4j with its Browser on this machine.

    It needs no Docker, no root and no Java of the system.
    """


@server_command.command("start")
@click.option("--bolt-port", type=click.IntRange(0, 65535), default=7687, show_default=True, help="0 takes a free one.")
@click.option("--http-port", type=click.IntRange(0, 65535), default=7474, show_default=True, help="0 takes a free one.")
@click.option("--heap-mb", type=click.IntRange(256), default=512, show_default=True, help="Memory for Java's objects.")
def start_command(bolt_port: int, http_port: int, heap_mb: int) -> None:
    """Fetch Neo4j on first use, start it and wait until it answers."""
    settings = Settings(bolt_port=bolt_port, http_port=http_port, heap_mb=heap_mb)
    with progress_bars() as bars:
        running = start(settings=settings, progress=bars)
    _print(running)


@server_command.command("stop")
def stop_command() -> None:
    """Stop the server and wait until it is gone."""
    ERR.print("The server has stopped." if stop() else "No server was running.")


@server_command.command("status")
@click.pass_context
def status_command(ctx: click.Context) -> None:
    """Say whether the server runs, and where; exit status 1 if not."""
    running = status()
    if running is None:
        ERR.print("No server is running; `enfilade server start` starts one.")
        ctx.exit(1)
    _print(running)


def _print(running: ServerStatus) -> None:
    OUT.print(f"Neo4j {running.version} is running (process {running.pid})")
    OUT.print(f"  store     {running.url}")
    OUT.print(f"  browser   {running.browser}")
    OUT.print(f"  user      {USER}, password in {running.password_file}", markup=False)
