"""The studio on this machine: a free port, an address with a token, and a browser that opens it."""

from __future__ import annotations

import secrets
import signal
import socket
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from types import FrameType

from fab.errors import InvalidJob

__all__ = ["PORT", "free_socket", "serve"]

# Where it looks for a free port first, and how many it tries.
PORT, _TRIED = 8765, 50
_HOST = "127.0.0.1"
_TOKEN_BYTES = 24


def free_socket(port: int = PORT) -> socket.socket:
    """A socket bound to this machine alone, at a port or the next free one.

    Raises `InvalidJob` where none of 50 is free.
    """
    for number in range(port, min(port + _TRIED, 65536)):
        found = socket.socket(socket.AF_INET, socket.SOCK_STREAM)
        try:
            found.bind((_HOST, number))
            found.listen(64)
        except OSError:
            found.close()
        else:
            return found
    raise InvalidJob(f"no port of {port} to {port + _TRIED - 1} is free. Give another --port.")


def serve(
    folder: Path,
    file: Path | None,
    *,
    port: int = PORT,
    allow_code: bool = False,
    tell: Callable[[str], None] = print,
    show: Callable[[str], object] | None = None,
    ended: Callable[[], bool] = lambda: False,
) -> None:
    """Serve the studio until it is interrupted, or its terminal is closed.

    folder : where it reads and writes; file : in it, to begin with. tell : takes lines about the
    address. show : opens an address in a browser. ended : whether it was interrupted before it
    could heed that, as while libraries are imported.
    """
    import uvicorn

    from fab.studio.app import Studio, studio_app

    bound = free_socket(port)
    number = bound.getsockname()[1]
    studio = Studio(folder, secrets.token_urlsafe(_TOKEN_BYTES), file, allow_code)
    hosts = frozenset({f"{_HOST}:{number}", f"localhost:{number}"})
    address = f"http://{_HOST}:{number}/{studio.token}/"
    if number != port:
        tell(f"port {port} is taken: {number} in its place")
    tell(f"studio: {address}")
    tell(f"It reads and writes in {folder}. Ctrl-C ends it.")
    if show is not None:
        threading.Thread(target=show, args=(address,), daemon=True).start()
    config = uvicorn.Config(
        studio_app(studio, hosts), log_level="error", access_log=False, server_header=False
    )

    class Server(uvicorn.Server):
        """One that waits for no work when it ends."""

        async def startup(self, sockets: list[socket.socket] | None = None) -> None:
            await super().startup(sockets)
            self.should_exit |= ended()  # from here on interrupts are its own

        def handle_exit(self, sig: int, frame: FrameType | None) -> None:
            super().handle_exit(sig, frame)
            studio.stop()

    server = Server(config)
    with bound, _closed_terminal(server.handle_exit):
        server.run(sockets=[bound])


@contextmanager
def _closed_terminal(end: Callable[[int, FrameType | None], None]) -> Iterator[None]:
    """What is done when the terminal is closed, which the server has no handler for."""
    number = getattr(signal, "SIGHUP", None)
    in_main = threading.current_thread() is threading.main_thread()
    if number is None or not in_main or signal.getsignal(number) is signal.SIG_IGN:
        yield
        return
    before = signal.signal(number, end)
    try:
        yield
    finally:
        signal.signal(number, before)
