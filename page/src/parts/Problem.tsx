import type { Problem } from "../api/types";
import { texts } from "../texts";
import { Words } from "./Words";

interface Props {
  problem: Problem;
  again?: () => void;
  toLine?: (line: number) => void;
}

/** A refusal in plain words: what happened, where, and what to do. */
export function ProblemBox({ problem, again, toLine }: Props) {
  const t = texts.value;
  const gone = problem.status === 0;
  const faults = problem.errors?.filter((fault) => fault.detail !== problem.detail) ?? [];
  return (
    <div class="notice bad" role="alert">
      <p class="title">{gone ? t.problem.noAnswer : problem.title}</p>
      <p>{gone ? t.problem.noAnswerDetail : <Words text={problem.detail} />}</p>
      {typeof problem.line === "number" && (
        <p>
          {toLine ? (
            <button type="button" class="link" onClick={() => toLine(problem.line as number)}>
              {t.common.line(problem.line)}
            </button>
          ) : (
            <strong>{t.common.line(problem.line)}</strong>
          )}
          {problem.block && <code class="block">{problem.block}</code>}
        </p>
      )}
      {faults.length > 0 && (
        <>
          <p class="hint">{t.problem.values}</p>
          <ul class="faults">
            {faults.slice(0, 12).map((fault) => (
              <li key={fault.pointer + fault.detail}>
                <code>{fault.pointer}</code> <Words text={fault.detail} />
              </li>
            ))}
          </ul>
        </>
      )}
      <p class="row">
        {again && (
          <button type="button" onClick={again}>
            {t.common.again}
          </button>
        )}
        {problem.type.startsWith("/problems/") && (
          <a href={problem.type} target="_blank" rel="noreferrer">
            {t.problem.about}
          </a>
        )}
      </p>
    </div>
  );
}
