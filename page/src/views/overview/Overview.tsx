import { jobs as jobsOf } from "../../api/jobs";
import { machines as allMachines } from "../../api/machines";
import { useAsked, useDoing } from "../../api/use";
import { usePictures } from "../../machine3d/ready";
import { Card, Empty, Got, Head } from "../../parts/parts";
import { ProblemBox } from "../../parts/Problem";
import { Words } from "../../parts/Words";
import { to } from "../../router";
import { texts } from "../../texts";
import { startTour } from "../../tour/tour";
import { NoMachine } from "../MachineChoice";
import { JobTable } from "../jobs/JobTable";
import { MachineCard } from "../machines/MachineCard";

export function Overview() {
  const t = texts.value.overview;
  usePictures();
  const machines = useAsked((signal) => allMachines(signal), []);
  const doing = useDoing();
  const jobs = useAsked((signal) => jobsOf({ limit: 8 }, signal), []);
  return (
    <>
      <Head title={t.title} lead={t.lead}>
        <a class="button primary" href={to("compensate")}>
          {t.compensate}
        </a>
      </Head>
      <h2 class="hidden">{t.machines}</h2>
      <Got asked={machines}>
        {({ items }) =>
          items.length === 0 ? (
            <NoMachine />
          ) : (
            <div class="cards">
              {items.map((machine) => (
                <MachineCard key={machine.machine_id} machine={machine} />
              ))}
            </div>
          )
        }
      </Got>
      <div class="grid overview">
        <Card title={t.recent} tools={<a href={to("jobs")}>{t.allJobs}</a>}>
          <Got asked={jobs}>
            {({ items }) => (items.length === 0 ? <Empty what={t.noJobs} cure={t.noJobsCure} /> : <JobTable jobs={items} />)}
          </Got>
        </Card>
        <div class="column">
          <Card title={t.tourTitle} class="tourcard">
            <p>{t.tourLead}</p>
            <button type="button" onClick={() => doing.run(startTour)}>
              {t.tourStart}
            </button>
          </Card>
          {jobs.data?.items.length === 0 && (
            <Card title={t.demoTitle} class="democard">
              <p>
                <Words text={t.demoLead} />
              </p>
              <button
                type="button"
                disabled={doing.busy}
                onClick={() =>
                  doing.run(async () => {
                    const { loadDemo } = await import("../../tour/demo");
                    await loadDemo();
                    jobs.again();
                    machines.again();
                  })
                }
              >
                {t.demoLoad}
              </button>
            </Card>
          )}
          {doing.problem && <ProblemBox problem={doing.problem} />}
        </div>
      </div>
    </>
  );
}
