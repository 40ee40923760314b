"""The workshop: `python -m docs.make` writes every page that is made from committed results, or checks it."""
