import { useState } from "preact/hooks";
import { texts } from "../../texts";

interface Props {
  file: File | null;
  choose: (file: File) => void;
}

/** Where a program is dropped, or chosen with the keyboard. */
export function Drop({ file, choose }: Props) {
  const t = texts.value.compensate;
  const [over, setOver] = useState(false);
  return (
    <label
      class={`drop ${over ? "over" : ""} ${file ? "full" : ""}`}
      onDragOver={(event) => {
        event.preventDefault();
        setOver(true);
      }}
      onDragLeave={() => setOver(false)}
      onDrop={(event) => {
        event.preventDefault();
        setOver(false);
        const dropped = event.dataTransfer?.files[0];
        if (dropped) choose(dropped);
      }}
    >
      <input
        type="file"
        id="program"
        class="hidden"
        onChange={(event) => {
          const chosen = event.currentTarget.files?.[0];
          if (chosen) choose(chosen);
        }}
      />
      {file ? (
        <>
          <strong>{file.name}</strong>
          <span class="hint">
            {t.size((file.size / 1000).toFixed(1))} · <span class="link">{t.other}</span>
          </span>
        </>
      ) : (
        <>
          <strong>{t.drop}</strong>
          <span class="hint">{t.dropHint}</span>
        </>
      )}
    </label>
  );
}
