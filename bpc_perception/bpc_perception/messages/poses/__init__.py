"""Poses of the flange from and to messages, whatever tells them."""
