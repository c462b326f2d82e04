"""Cross-checks of a description: findings, each with its place and remedy."""
