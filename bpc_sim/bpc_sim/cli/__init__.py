"""The commands of the simulator, which ``bpc`` finds as entry points.

Every command of bpc loads these modules: they import the simulator late, when it is needed.
"""
