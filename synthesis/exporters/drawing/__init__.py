"""SVG and HTML: elements, one style for all drawings, pages that stand alone, and PNG of drawings.

In: texts and coordinates. Out: elements as strings, whole documents as bytes. ``canvas`` has the
elements, the style and the two lines above every drawing, ``html`` the page, ``raster`` paints a
drawing as PNG. Open ``canvas`` first.
"""
