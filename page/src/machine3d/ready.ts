// The code of the pictures is large. Views from which a picture is opened, or in which it comes later, load it before.

import { useEffect } from "preact/hooks";

/** After what the view itself asks for. */
const LATER_MS = 300;

export function usePictures(delay_ms = LATER_MS): void {
  useEffect(() => {
    const timer = setTimeout(() => void Promise.all([import("./stage"), import("./pathScene"), import("./poses")]), delay_ms);
    return () => clearTimeout(timer);
  }, []);
}
