"""Reading scores from pictures: pages of paper, and the staves of Labanotation on them."""
