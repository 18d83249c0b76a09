"""What can go wrong behind a supervisor's back: as functions, as promises, and flown by the hundred."""
