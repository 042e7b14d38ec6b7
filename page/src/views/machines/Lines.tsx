import type { ComponentChildren } from "preact";
import type { LocationError, Machine } from "../../api/types";
import { Num } from "../../parts/Num";
import { Card } from "../../parts/parts";
import { to } from "../../router";
import { texts } from "../../texts";

const ERRORS = ["e_x_um", "e_y_um", "e_z_um", "e_a_urad", "e_b_urad", "e_c_urad"] as const satisfies (keyof LocationError)[];

interface Props {
  machine: Machine;
  calibration: string | null;
  children?: ComponentChildren;
}

/** The lines of the rotary axes, their limits and their location errors. */
export function Lines({ machine, calibration, children }: Props) {
  const t = texts.value.machines;
  return (
    <Card title={t.errors}>
      <div class="scroll" tabIndex={0} role="region" aria-label={t.errors}>
        <table class="list numeric">
          <thead>
            <tr>
              <th scope="col">{t.axis}</th>
              <th scope="col">{t.side}</th>
              <th scope="col">{t.direction}</th>
              <th scope="col">{t.point}</th>
              <th scope="col">{t.limits}</th>
              {ERRORS.map((name) => (
                <th scope="col" class="right" key={name}>
                  {name.replace(/_u(m|rad)$/, "").replaceAll("_", "")} <span class="unit">{name.endsWith("um") ? "µm" : "µrad"}</span>
                </th>
              ))}
            </tr>
          </thead>
          <tbody>
            {machine.kinematics.rotary_axes.map((axis) => (
              <tr key={axis.name} data-axis={axis.name}>
                <th scope="row">{axis.name}</th>
                <td>{t.sides[axis.side]}</td>
                <td class="num nowrap">{axis.direction.map((part) => Number(part.toFixed(4))).join("  ")}</td>
                <td class="num nowrap">{axis.point_mm.map((part) => Number(part.toFixed(4))).join("  ")}</td>
                <td class="num nowrap">{axis.limits_deg ? `${axis.limits_deg.join("…")}°`.replaceAll("-", "−") : t.unlimited}</td>
                {ERRORS.map((name) => (
                  <td class="right" key={name}>
                    <Num value={axis.location_error?.[name] ?? 0} />
                  </td>
                ))}
              </tr>
            ))}
          </tbody>
        </table>
      </div>
      {calibration && (
        <p class="hint">
          {t.fromRun} <a href={to("calibrate", machine.machine_id, calibration)}>{t.openRun}</a>
        </p>
      )}
      {children}
    </Card>
  );
}
