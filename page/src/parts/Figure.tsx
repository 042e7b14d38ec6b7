import { useEffect, useState } from "preact/hooks";
import { ask } from "../api/client";
import { useAsked } from "../api/use";
import { Got } from "./parts";

/** A figure that the service draws. It comes with the key, and so is not the address of an image. */
export function Figure({ path, alt, body }: { path: string; alt: string; body?: unknown }) {
  const asked = useAsked(
    async (signal) => {
      const asking = body === undefined ? {} : { method: "POST", json: body };
      return (await ask(path, { accept: "image/svg+xml", signal, ...asking })).blob();
    },
    [path, JSON.stringify(body)],
  );
  return (
    <Got asked={asked}>
      {(blob) => <Shown blob={blob} alt={alt} />}
    </Got>
  );
}

function Shown({ blob, alt }: { blob: Blob; alt: string }) {
  const [address, setAddress] = useState("");
  useEffect(() => {
    const made = URL.createObjectURL(blob);
    setAddress(made);
    return () => URL.revokeObjectURL(made);
  }, [blob]);
  return address ? <img class="figure" src={address} alt={alt} /> : null;
}
