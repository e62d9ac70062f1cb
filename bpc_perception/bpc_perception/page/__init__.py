"""The live page: what a person at the printer wants to see of a print, in a browser.

The modules ``server``, ``view``, ``elements`` and ``panels`` need NiceGUI; only the node ``page``
imports them. All that the command line has to know of the page is here.
"""

HOST = '127.0.0.1'
TOKEN_VARIABLE = 'BPC_PAGE_TOKEN'  # not a parameter: everybody in the graph can read those


def address_at(port: int, token: str) -> str:
    """Return the address of the page for a person who may act on it."""
    return f'http://{HOST}:{port}/?token={token}'
