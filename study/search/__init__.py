"""The search for designs: a space of choices, generations, trials that no crash takes away, and costs."""
