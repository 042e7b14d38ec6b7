-- The trace that a posted job belongs to (W3C Trace Context): what its webhook hands on. None where the job was computed within
-- its request, or posted before this was there.
ALTER TABLE jobs ADD COLUMN traceparent TEXT CHECK (traceparent IS NULL OR length(traceparent) = 55);
