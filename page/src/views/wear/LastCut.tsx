import { jobs as jobsOf } from "../../api/jobs";
import { useAsked } from "../../api/use";
import { moment } from "../../parts/format";
import { Card, Empty, Got } from "../../parts/parts";
import { to } from "../../router";
import { texts } from "../../texts";
import { ResidualMap } from "../result/ResidualMap";

/** What the last virtual cutting on this machine has left on the part. */
export function LastCut({ id }: { id: string }) {
  const t = texts.value.wear;
  const asked = useAsked((signal) => jobsOf({ machine_id: id, operation: "verification", state: "succeeded", limit: 1 }, signal), [id]);
  return (
    <Got asked={asked}>
      {({ items: [job] }) =>
        job ? (
          <>
            <p class="hint noprint">
              {t.lastCut} <a href={to("jobs", job.id)}>{job.external_id ?? moment(job.created_at)}</a>
            </p>
            <ResidualMap job={job} />
          </>
        ) : (
          <Card title={texts.value.result.residualMap} class="noprint">
            <Empty what={t.noCut} cure={t.noCutCure} />
          </Card>
        )
      }
    </Got>
  );
}
