"""What every drawing and page is made of: SVG and HTML by hand, themes, pixels."""
