FROM python:3.11-slim

RUN apt-get update && apt-get install -y --no-install-recommends make && rm -rf /var/lib/apt/lists/*

RUN useradd --create-home --shell /bin/bash user
USER user
WORKDIR /home/user/rlbench-pin
COPY --chown=user:user . .
RUN make setup

CMD ["make", "demo"]
