import { profileOf, revisions as revisionsOf } from "../../api/machines";
import type { Machine } from "../../api/types";
import { useAsked } from "../../api/use";
import { moment } from "../../parts/format";
import { Card, Got } from "../../parts/parts";
import { texts } from "../../texts";

/** The names of the members that differ, with their values. */
export function difference(from: unknown, to: unknown, name = ""): string[] {
  if (from === to) return [];
  const both = [from, to].every((one) => one !== null && typeof one === "object");
  if (!both) return [`${name}: ${said(from)} → ${said(to)}`];
  const [a, b] = [from, to] as [Record<string, unknown>, Record<string, unknown>];
  return [...new Set([...Object.keys(a), ...Object.keys(b)])].flatMap((member) =>
    difference(a[member], b[member], name ? `${name}.${member}` : member),
  );
}

const said = (value: unknown) => (typeof value === "number" ? String(Number(value.toFixed(3))) : (JSON.stringify(value) ?? "–"));

const SHOWN = 14;

export function Revisions({ id, now }: { id: string; now: number }) {
  const t = texts.value;
  const asked = useAsked(() => revisionsOf(id), [id, now]);
  return (
    <Card title={t.machines.revisions}>
      <Got asked={asked}>
        {({ items }) => (
          <ol class="revisions">
            {items.map((revision, index) => (
              <li key={revision.revision}>
                <p>
                  <strong>{t.common.revision(revision.revision)}</strong> <span class="hint">{moment(revision.created_at)}</span>
                </p>
                <Changes revision={revision} before={items[index + 1]} />
              </li>
            ))}
          </ol>
        )}
      </Got>
    </Card>
  );
}

/** With the letter of an axis in place of its number. */
const named = (change: string, { kinematics }: Machine) =>
  change
    .replace(/^kinematics\.rotary_axes\.(\d)/, (_all, index: string) => kinematics.rotary_axes[Number(index)]?.name ?? index)
    .replace(".location_error", "");

function Changes({ revision, before }: { revision: Machine; before: Machine | undefined }) {
  const t = texts.value.machines;
  if (!before) return <p class="hint">{revision.revision === 1 ? t.first : ""}</p>;
  const changes = difference(profileOf(before), profileOf(revision));
  return (
    <ul class="changes">
      {changes.slice(0, SHOWN).map((change) => (
        <li key={change}>
          <code>{named(change, revision)}</code>
        </li>
      ))}
      {changes.length > SHOWN && <li class="hint">… {changes.length - SHOWN}</li>}
    </ul>
  );
}
