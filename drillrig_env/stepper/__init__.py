"""The fast exact step: tables, collocation, kinks, propagation, batches."""
