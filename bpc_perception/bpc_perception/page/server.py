"""The page's web server: NiceGUI in a thread of its own, on loopback."""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from concurrent.futures import Future
from contextlib import suppress
from pathlib import Path
import socket
from threading import Thread

from fastapi import FastAPI, Request, Response
from nicegui import Client, ui
import uvicorn

from bpc_perception.page import address_at, HOST
from bpc_perception.page.board import Board
from bpc_perception.page.guard import allows, Guard, tokens
from bpc_perception.page.view import View

BROWSER_TIMEOUT_S = 60.0  # for a browser that asked for the page to connect, and to answer
ACT_TIMEOUT_S = 20.0  # for what a button does
END_TIMEOUT_S = 1.0  # for browsers, when the server ends
RECONNECT_TIMEOUT_S = 10.0  # for a browser whose connection is lost
MISSED_MESSAGES = 300  # kept for such a browser; if it missed more, it loads the page anew
AGES_PERIOD_S = 1.0  # in which the ages on the page are brought up to date
STYLE_FILE = Path(__file__).with_name('page.css')


class PageServer:
    """Serves a board to any number of browsers until it is closed; one for each process.

    Args:
        board: what is shown.
        port: 0 = any that is free.
        token: has to be in the address for buttons.
        act: starts what a button says; the outcome is whether it was done, and in words.
        on_watchers: is called in the server's thread with the number of browsers that look, when
            that changes.

    Raises:
        OSError: the port is taken.
    """

    def __init__(self, board: Board, port: int, token: str,
                 act: Callable[[str], Future[tuple[bool, str]]],
                 on_watchers: Callable[[int], None]) -> None:
        self._board = board
        self._token = token
        self._act_in_node = act
        self._on_watchers = on_watchers
        self._views: dict[str, View] = {}
        self._loop: asyncio.AbstractEventLoop | None = None
        try:
            self._socket = socket.create_server((HOST, port))
        except OSError as error:
            raise OSError(f'port: expected {port} to be free, found: {error.strerror}'
                          '; end what listens there, or set port to another') from error
        self._server = uvicorn.Server(uvicorn.Config(
            self._make_app(), log_config=None, access_log=False, server_header=False,
            timeout_graceful_shutdown=round(END_TIMEOUT_S),
            # To compress takes longer than to send within this computer.
            ws_per_message_deflate=False))
        self._thread = Thread(target=self._server.run, args=([self._socket],), daemon=True)
        self._thread.start()

    @property
    def address(self) -> str:
        """The address of the page, with its token."""
        return address_at(self._socket.getsockname()[1], self._token)

    def notify(self) -> None:
        """Show what is new on the board; may be called from any thread."""
        if self._loop is not None and self._views:
            try:
                self._loop.call_soon_threadsafe(self._refresh)
            except RuntimeError:  # the server has ended
                return

    def close(self) -> None:
        """End the server."""
        self._server.should_exit = True
        self._thread.join(2 * END_TIMEOUT_S)
        self._socket.close()

    def _refresh(self) -> None:
        for view in list(self._views.values()):
            view.refresh()

    def _make_app(self) -> Guard:
        app = FastAPI(openapi_url=None, docs_url=None, redoc_url=None)

        @app.get('/overlay.jpg')
        def overlay() -> Response:
            shown = self._board.overlay
            if shown is None:
                return Response(status_code=404)
            return Response(shown.jpeg, media_type='image/jpeg',
                            headers={'Cache-Control': 'no-store'})

        ui.page('/', title='bpc', favicon=ICON)(self._serve)
        ui.run_with(app, dark=None, tailwind=False, show_welcome_message=False,
                    reconnect_timeout=RECONNECT_TIMEOUT_S, message_history_length=MISSED_MESSAGES)
        return Guard(app, self._token)

    async def _serve(self, request: Request, client: Client) -> None:
        """Make the page for a browser, and keep it up to date while the browser is connected."""
        self._loop = asyncio.get_running_loop()
        ui.add_css(STYLE_FILE)
        # The guard has refused wrong tokens already; without a token there are no buttons.
        acting = any(allows(self._token, token) for token in tokens(request.scope))
        view = View(self._board, self._act if acting else None)
        ui.timer(AGES_PERIOD_S, view.refresh)
        client.on_delete(lambda: self._leave(client.id))
        with suppress(TimeoutError, asyncio.TimeoutError):  # the browser has gone
            await client.connected(BROWSER_TIMEOUT_S)
            self._views[client.id] = view
            self._on_watchers(len(self._views))
            view.dark = bool(await ui.run_javascript('Quasar.Dark.isActive',
                                                     timeout=BROWSER_TIMEOUT_S))
            view.refresh()

    def _leave(self, client_id: str) -> None:
        if self._views.pop(client_id, None) is not None:
            self._on_watchers(len(self._views))

    async def _act(self, name: str) -> tuple[bool, str]:
        try:
            return await asyncio.wait_for(asyncio.wrap_future(self._act_in_node(name)),
                                          ACT_TIMEOUT_S)
        except asyncio.TimeoutError:
            return False, f'no answer within {ACT_TIMEOUT_S:.0f} s'


# A bead along a path.
ICON = ('<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 32 32"><path '
        'd="M4 22c6 0 6-12 12-12s6 12 12 12" fill="none" stroke="#0072B2" stroke-width="6" '
        'stroke-linecap="round"/></svg>')
