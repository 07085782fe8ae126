"""Results of evaluations: records, the file, rates with intervals, comparisons, tables and plots."""
