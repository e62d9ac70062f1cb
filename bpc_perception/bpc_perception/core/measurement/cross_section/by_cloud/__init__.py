"""Beads as the cloud shows them, whatever their colour is."""
