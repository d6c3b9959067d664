"""Robot programs read: KRL, RAPID, URScript, FANUC TP listings, Yaskawa INFORM; literal targets alone."""
