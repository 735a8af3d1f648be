"""What may hold a warehouse up, and the model without it: what `why` simulates."""
