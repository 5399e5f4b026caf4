"""The search for designs: a space of choices, generations, trials that survive a crash, and costs."""
