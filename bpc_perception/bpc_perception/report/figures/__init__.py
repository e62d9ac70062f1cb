"""The figures of the report, interactive: lengths in millimetres.

Draw lines rather than markers wherever there are as many points as samples: a browser keeps one
element for a line, but one for each marker. Numbers are single precision, since they make up half
of the page.
"""
