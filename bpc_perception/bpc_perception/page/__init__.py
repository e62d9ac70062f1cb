"""The live page: what a person at the printer wants to see of a print, in a browser.

Only the node ``page`` imports this, so that nothing else needs NiceGUI.
"""
