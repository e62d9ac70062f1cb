"""The live page: what a person at the printer wants to see of a print, in a browser.

Of its modules ``server`` and ``view`` need NiceGUI, and only the node ``page`` imports them.
What is here is all that the command line has to know of it.
"""

HOST = '127.0.0.1'
TOKEN_VARIABLE = 'BPC_PAGE_TOKEN'  # not a parameter: those anybody in the graph can read


def address_at(port: int, token: str) -> str:
    """Where the page is, for who may act on it."""
    return f'http://{HOST}:{port}/?token={token}'
