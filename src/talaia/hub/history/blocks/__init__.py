"""How samples are laid down: batches, blocks, sums of them."""
