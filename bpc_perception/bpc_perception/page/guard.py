"""Who may see the page, and who may act: checked before each request is handled.

The page is served on loopback only. That alone leaves three ways in, which are closed here: a
foreign host name that is made to point at this computer (DNS rebinding), a foreign page in the
same browser, and other users of this computer, who may look but not act.
"""

from __future__ import annotations

import re
import secrets
from typing import Any
from urllib.parse import parse_qs

from starlette.datastructures import Headers, MutableHeaders
from starlette.responses import PlainTextResponse
from starlette.types import ASGIApp, Message, Receive, Scope, Send

HOSTS = re.compile(r'(127\.0\.0\.1|localhost)(:\d{1,5})?')  # any port: a tunnel may change it
CLOSE_REFUSED = 1008  # RFC 6455: the endpoint received what violates its policy
# NiceGUI writes scripts and styles into the page and compiles its templates there. Whatever it
# does, the page loads nothing from another host, and no other page may embed this one.
POLICY = ("default-src 'self' data: blob:; script-src 'self' 'unsafe-inline' 'unsafe-eval'; "
          "style-src 'self' 'unsafe-inline'; frame-ancestors 'none'; form-action 'none'; "
          "base-uri 'none'; object-src 'none'")
HEADERS = {
    'Content-Security-Policy': POLICY,
    'Cross-Origin-Resource-Policy': 'same-origin',
    'Referrer-Policy': 'no-referrer',  # the address holds the token
    'X-Content-Type-Options': 'nosniff',
    'X-Frame-Options': 'DENY',
}


class Guard:
    """ASGI middleware that lets only requests through that came by the page's own address.

    Args:
        app: what it guards.
        token: has to be in the address of a person who wants to act.
    """

    def __init__(self, app: ASGIApp, token: str) -> None:
        self._app = app
        self._token = token

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Refuse a request, or hand it on to the application."""
        if scope['type'] == 'lifespan':
            await self._app(scope, receive, send)
            return
        refusal = self.refusal(scope)
        if refusal is None:
            await self._app(scope, receive, _with_headers(send))
        elif scope['type'] == 'websocket':
            await send({'type': 'websocket.close', 'code': CLOSE_REFUSED})
        else:
            await PlainTextResponse(refusal, status_code=403)(
                scope, receive, _with_headers(send))

    def refusal(self, scope: Scope) -> str | None:
        """Return why a request is refused; None if it is not."""
        headers = Headers(scope=scope)
        host = headers.get('host', '')
        if not HOSTS.fullmatch(host):
            return 'expected to be asked as 127.0.0.1 or localhost, found another host'
        origin = headers.get('origin')
        if origin is not None and origin not in (f'http://{host}', f'https://{host}'):
            return 'expected a request from this page, found one from another'
        if any(not allows(self._token, token) for token in tokens(scope)):
            return ('expected the token of this run, found another: '
                    'the terminal shows the address that holds now')
        return None


def tokens(scope: Scope) -> list[str]:
    """Return the tokens in the address of a request."""
    query: Any = parse_qs(scope.get('query_string', b'').decode('latin-1'),
                          keep_blank_values=True)
    values: list[str] = query.get('token', [])
    return values


def allows(token: str, given: str) -> bool:
    """Return whether this is the token, in a time that does not show how much of it is right."""
    return secrets.compare_digest(token.encode(), given.encode())


def _with_headers(send: Send) -> Send:
    """Return a sender that adds HEADERS to the response."""
    async def send_with_headers(message: Message) -> None:
        if message['type'] == 'http.response.start':
            headers = MutableHeaders(scope=message)
            for name, value in HEADERS.items():
                headers[name] = value
        await send(message)
    return send_with_headers
